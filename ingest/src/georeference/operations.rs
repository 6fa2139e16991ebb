//! The operations that PROJ knows from a reference system to WGS84, and the grids that it has not.

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::{self, NonNull};
use std::sync::Once;

/// The grids of the best operation to WGS84, where some are not there, and what remains without them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MissingGrids {
    /// A name each, and where PROJ knows one, an address.
    pub(crate) grids: Vec<String>,
    /// Metres by which places are off with them, where that is known.
    pub(crate) accuracy: Option<f64>,
    /// The same of the best operation without, where there is one that shifts the datum at all.
    pub(crate) without: Option<Option<f64>>,
}

/// The grids that are missed for places between west, south, east and north, in degrees; longitudes of any turn.
pub(crate) fn missing_grids(from: &str, area: [f64; 4]) -> Option<MissingGrids> {
    let operations = Operations::to_wgs84(from, area)?;
    let best = operations.get(0)?;
    if best.is_instantiable() {
        return None;
    }
    Some(MissingGrids {
        grids: best.absent_grids(),
        accuracy: best.accuracy(),
        without: operations.usable().next().map(|operation| operation.accuracy()),
    })
}

/// The best of several operations for an area, as a text for PROJ, longitudes and x first; none where there is no choice. Left to
/// itself, PROJ chooses for each point, and places jump from one to the next.
pub(super) fn one_for_all(from: &str, area: [f64; 4]) -> Option<String> {
    let operations = Operations::to_wgs84(from, area)?;
    let mut usable = operations.usable();
    let best = usable.next()?;
    usable.next()?;
    best.definition()
}

/// PROJ's operations from one reference system to another, the best first, whether their grids are there or not.
struct Operations {
    context: Context,
    list: NonNull<proj_sys::PJ_OBJ_LIST>,
}

impl Operations {
    /// Between west, south, east and north, in degrees; longitudes of any turn.
    fn to_wgs84(from: &str, [west, south, east, north]: [f64; 4]) -> Option<Self> {
        silence();
        let area = if east - west < 360.0 {
            let [west, east] = [west, east].map(|longitude| longitude - 360.0 * ((longitude + 180.0) / 360.0).floor());
            [west, south, east, north]
        } else {
            [-180.0, south, 180.0, north]
        };
        Self::new(from, "EPSG:4326", area)
    }

    /// Those whose grids are there, and that shift the datum.
    fn usable(&self) -> impl Iterator<Item = Operation<'_>> {
        let all = (0..self.count()).filter_map(|index| self.get(index));
        all.filter(|operation| operation.is_instantiable() && !operation.is_ballpark())
    }

    fn new(from: &str, to: &str, [west, south, east, north]: [f64; 4]) -> Option<Self> {
        let context = Context::new()?;
        let [from, to] = [context.object(from)?, context.object(to)?];
        // SAFETY: the context lives; both systems and the settings do until they are destroyed here, and the list does not need them.
        let list = unsafe {
            let settings = proj_sys::proj_create_operation_factory_context(context.0.as_ptr(), ptr::null());
            proj_sys::proj_operation_factory_context_set_area_of_interest(
                context.0.as_ptr(),
                settings,
                west,
                south,
                east,
                north,
            );
            proj_sys::proj_operation_factory_context_set_spatial_criterion(
                context.0.as_ptr(),
                settings,
                proj_sys::PROJ_SPATIAL_CRITERION_PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION,
            );
            proj_sys::proj_operation_factory_context_set_grid_availability_use(
                context.0.as_ptr(),
                settings,
                proj_sys::PROJ_GRID_AVAILABILITY_USE_PROJ_GRID_AVAILABILITY_IGNORED,
            );
            let list = proj_sys::proj_create_operations(context.0.as_ptr(), from.as_ptr(), to.as_ptr(), settings);
            proj_sys::proj_operation_factory_context_destroy(settings);
            proj_sys::proj_destroy(from.as_ptr());
            proj_sys::proj_destroy(to.as_ptr());
            list
        };
        NonNull::new(list).map(|list| Self { context, list })
    }

    fn count(&self) -> c_int {
        // SAFETY: the list lives as long as `self`.
        unsafe { proj_sys::proj_list_get_count(self.list.as_ptr()) }
    }

    fn get(&self, index: c_int) -> Option<Operation<'_>> {
        // SAFETY: context and list live as long as `self`; beyond the list's end PROJ gives null.
        let operation = unsafe { proj_sys::proj_list_get(self.context.0.as_ptr(), self.list.as_ptr(), index) };
        let operation = NonNull::new(operation)?;
        Some(Operation {
            context: &self.context,
            operation,
        })
    }
}

impl Drop for Operations {
    fn drop(&mut self) {
        // SAFETY: it was made by PROJ and is not used any more.
        unsafe { proj_sys::proj_list_destroy(self.list.as_ptr()) }
    }
}

/// One of the operations.
struct Operation<'a> {
    context: &'a Context,
    operation: NonNull<proj_sys::PJ>,
}

impl Operation<'_> {
    fn is_instantiable(&self) -> bool {
        // SAFETY: context and operation live as long as `self`.
        unsafe { proj_sys::proj_coordoperation_is_instantiable(self.context.0.as_ptr(), self.operation.as_ptr()) != 0 }
    }

    fn is_ballpark(&self) -> bool {
        // SAFETY: as above.
        unsafe {
            proj_sys::proj_coordoperation_has_ballpark_transformation(self.context.0.as_ptr(), self.operation.as_ptr())
                != 0
        }
    }

    fn accuracy(&self) -> Option<f64> {
        // SAFETY: as above. PROJ gives a negative number where it knows none.
        let metres =
            unsafe { proj_sys::proj_coordoperation_get_accuracy(self.context.0.as_ptr(), self.operation.as_ptr()) };
        (metres >= 0.0).then_some(metres)
    }

    fn definition(&self) -> Option<String> {
        let context = self.context.0.as_ptr();
        // SAFETY: as above; the operation with x first lives until its text is copied.
        unsafe {
            let x_first = proj_sys::proj_normalize_for_visualization(context, self.operation.as_ptr());
            let x_first = NonNull::new(x_first)?;
            let version = proj_sys::PJ_PROJ_STRING_TYPE_PJ_PROJ_5;
            let definition = text(proj_sys::proj_as_proj_string(
                context,
                x_first.as_ptr(),
                version,
                ptr::null(),
            ));
            proj_sys::proj_destroy(x_first.as_ptr());
            (!definition.is_empty()).then_some(definition)
        }
    }

    fn absent_grids(&self) -> Vec<String> {
        // SAFETY: as above.
        let count = unsafe {
            proj_sys::proj_coordoperation_get_grid_used_count(self.context.0.as_ptr(), self.operation.as_ptr())
        };
        (0..count).filter_map(|index| self.absent_grid(index)).collect()
    }

    fn absent_grid(&self, index: c_int) -> Option<String> {
        let (mut name, mut address): (*const c_char, *const c_char) = (ptr::null(), ptr::null());
        let mut is_there = 0;
        // SAFETY: as above; PROJ writes to what is given and takes null for what is not asked for.
        let is_known = unsafe {
            proj_sys::proj_coordoperation_get_grid_used(
                self.context.0.as_ptr(),
                self.operation.as_ptr(),
                index,
                &raw mut name,
                ptr::null_mut(),
                ptr::null_mut(),
                &raw mut address,
                ptr::null_mut(),
                ptr::null_mut(),
                &raw mut is_there,
            )
        };
        if is_known == 0 || is_there != 0 {
            return None;
        }
        let [name, address] = [name, address].map(text);
        Some(if address.is_empty() {
            name
        } else {
            format!("{name} ({address})")
        })
    }
}

impl Drop for Operation<'_> {
    fn drop(&mut self) {
        // SAFETY: it was made by PROJ and is not used any more.
        unsafe {
            proj_sys::proj_destroy(self.operation.as_ptr());
        }
    }
}

/// A context of PROJ for one thread.
struct Context(NonNull<proj_sys::PJ_CONTEXT>);

impl Context {
    fn new() -> Option<Self> {
        // SAFETY: it asks for nothing.
        NonNull::new(unsafe { proj_sys::proj_context_create() }).map(Self)
    }

    fn object(&self, definition: &str) -> Option<NonNull<proj_sys::PJ>> {
        let definition = CString::new(definition).ok()?;
        // SAFETY: the context lives as long as `self`, and PROJ copies the text, which ends in a zero.
        NonNull::new(unsafe { proj_sys::proj_create(self.0.as_ptr(), definition.as_ptr()) })
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: it was made by PROJ and is not used any more.
        unsafe {
            proj_sys::proj_context_destroy(self.0.as_ptr());
        }
    }
}

/// Keeps PROJ from printing to standard error; what goes wrong comes back as errors.
pub(super) fn silence() {
    static ONCE: Once = Once::new();
    // SAFETY: the null context is PROJ's default one, whose log level new contexts inherit. `Once` keeps this to one
    // thread, before any other context is made here.
    ONCE.call_once(|| unsafe {
        proj_sys::proj_log_level(ptr::null_mut(), proj_sys::PJ_LOG_LEVEL_PJ_LOG_NONE);
    });
}

/// A text of PROJ's, which lives as long as the operation that it is of.
fn text(of: *const c_char) -> String {
    if of.is_null() {
        return String::new();
    }
    // SAFETY: PROJ ends its texts with a zero.
    unsafe { CStr::from_ptr(of) }.to_string_lossy().into_owned()
}

#[cfg(test)]
#[path = "operations_tests.rs"]
mod tests;
