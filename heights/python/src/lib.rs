//! Heights for Python: what `terrain_heights.pyi` describes.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use terrain_heights::{Frame, Heights, HeightsError, Place, Point};

const MEASURED: u8 = 0;
const VOID: u8 = 1;
const OUTSIDE: u8 = 2;
const FILLED: u8 = 4;
/// Bytes of decoded surfaces, if nothing else is asked for.
const CACHE_BYTES: u64 = 256 << 20;

/// What there is at a place.
#[pyclass(frozen, get_all)]
struct Ground {
    status: u8,
    height: f64,
    error: f64,
    normal: (f64, f64, f64),
}

/// The same at many places.
#[pyclass(frozen, get_all)]
struct Grounds {
    status: Py<PyArray1<u8>>,
    height: Py<PyArray1<f64>>,
    error: Py<PyArray1<f64>>,
    normal: Py<PyArray2<f64>>,
}

/// A local frame.
#[pyclass(frozen, name = "Frame")]
struct LocalFrame(Frame);

#[pymethods]
impl LocalFrame {
    #[new]
    #[pyo3(signature = (longitude, latitude, height = 0.0))]
    fn new(longitude: f64, latitude: f64, height: f64) -> PyResult<Self> {
        let frame = Frame::at(longitude, latitude, height);
        frame
            .map(Self)
            .ok_or_else(|| PyValueError::new_err("there is no such place"))
    }

    /// Rows east, north and up.
    #[getter]
    fn axes(&self) -> [[f64; 3]; 3] {
        self.0.axes.to_cols_array_2d()
    }

    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.0.origin.to_array()
    }
}

/// An open archive.
#[pyclass(frozen, name = "Heights")]
struct OpenArchive(Heights);

#[pymethods]
impl OpenArchive {
    #[new]
    #[pyo3(signature = (path, cache_bytes = CACHE_BYTES))]
    fn new(py: Python<'_>, path: PathBuf, cache_bytes: u64) -> PyResult<Self> {
        let opened = py.detach(|| Heights::open(&path, cache_bytes));
        opened.map(Self).map_err(unreadable)
    }

    #[getter]
    fn above(&self) -> &str {
        self.0.above()
    }

    #[getter]
    fn finest_zoom(&self) -> u8 {
        self.0.finest_zoom()
    }

    #[pyo3(signature = (longitude, latitude, zoom = None))]
    fn at(&self, py: Python<'_>, longitude: f64, latitude: f64, zoom: Option<u8>) -> PyResult<Ground> {
        let found = py.detach(|| self.0.at(longitude, latitude, zoom.unwrap_or(u8::MAX)));
        found.map(Ground::of).map_err(unreadable)
    }

    #[pyo3(signature = (longitudes, latitudes, zoom = None))]
    fn at_many(
        &self,
        py: Python<'_>,
        longitudes: PyReadonlyArray1<'_, f64>,
        latitudes: PyReadonlyArray1<'_, f64>,
        zoom: Option<u8>,
    ) -> PyResult<Grounds> {
        Grounds::at(py, [longitudes, latitudes], |longitude, latitude| {
            self.0.at(longitude, latitude, zoom.unwrap_or(u8::MAX))
        })
    }

    #[pyo3(signature = (frame, east, north, zoom = None))]
    fn in_frame(
        &self,
        py: Python<'_>,
        frame: &LocalFrame,
        east: f64,
        north: f64,
        zoom: Option<u8>,
    ) -> PyResult<Ground> {
        let found = py.detach(|| self.0.in_frame(&frame.0, east, north, zoom.unwrap_or(u8::MAX)));
        found.map(Ground::of).map_err(unreadable)
    }

    #[pyo3(signature = (frame, easts, norths, zoom = None))]
    fn in_frame_many(
        &self,
        py: Python<'_>,
        frame: &LocalFrame,
        easts: PyReadonlyArray1<'_, f64>,
        norths: PyReadonlyArray1<'_, f64>,
        zoom: Option<u8>,
    ) -> PyResult<Grounds> {
        Grounds::at(py, [easts, norths], |east, north| {
            self.0.in_frame(&frame.0, east, north, zoom.unwrap_or(u8::MAX))
        })
    }
}

impl Ground {
    fn of(place: Place) -> Self {
        let none = |status| Self {
            status,
            height: f64::NAN,
            error: f64::NAN,
            normal: (f64::NAN, f64::NAN, f64::NAN),
        };
        let at = |status, point: Point, error| Self {
            status,
            height: point.height,
            error,
            normal: (point.normal.x, point.normal.y, point.normal.z),
        };
        match place {
            Place::Measured(point, error) => at(MEASURED, point, error),
            Place::Filled(point) => at(FILLED, point, f64::NAN),
            Place::Void => none(VOID),
            Place::Outside => none(OUTSIDE),
        }
    }
}

impl Grounds {
    /// What `ask` finds at pairs of numbers.
    fn at(
        py: Python<'_>,
        [firsts, seconds]: [PyReadonlyArray1<'_, f64>; 2],
        ask: impl Fn(f64, f64) -> Result<Place, HeightsError> + Sync,
    ) -> PyResult<Self> {
        let (firsts, seconds) = (firsts.to_vec()?, seconds.to_vec()?);
        if firsts.len() != seconds.len() {
            return Err(PyValueError::new_err("both arrays have as many numbers"));
        }
        let pairs = || firsts.iter().zip(&seconds);
        let found: Result<Vec<Place>, HeightsError> =
            py.detach(|| pairs().map(|(&one, &other)| ask(one, other)).collect());
        let grounds: Vec<Ground> = found.map_err(unreadable)?.into_iter().map(Ground::of).collect();
        Self::of(py, &grounds)
    }

    fn of(py: Python<'_>, grounds: &[Ground]) -> PyResult<Self> {
        let numbers = |of: fn(&Ground) -> f64| {
            let numbers: Vec<f64> = grounds.iter().map(of).collect();
            numbers.into_pyarray(py).unbind()
        };
        let status: Vec<u8> = grounds.iter().map(|ground| ground.status).collect();
        let normals: Vec<f64> = grounds
            .iter()
            .flat_map(|ground| <[f64; 3]>::from(ground.normal))
            .collect();
        let normals = normals.into_pyarray(py).reshape([grounds.len(), 3])?;
        Ok(Self {
            status: status.into_pyarray(py).unbind(),
            height: numbers(|ground| ground.height),
            error: numbers(|ground| ground.error),
            normal: normals.unbind(),
        })
    }
}

fn unreadable(error: HeightsError) -> PyErr {
    PyOSError::new_err(error.to_string())
}

/// As Python calls it; here it is not to be taken for the library that it wraps.
#[pymodule(name = "terrain_heights")]
fn python_module(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<LocalFrame>()?;
    module.add_class::<OpenArchive>()?;
    module.add_class::<Ground>()?;
    module.add_class::<Grounds>()?;
    module.add("MEASURED", MEASURED)?;
    module.add("VOID", VOID)?;
    module.add("OUTSIDE", OUTSIDE)?;
    module.add("FILLED", FILLED)
}
