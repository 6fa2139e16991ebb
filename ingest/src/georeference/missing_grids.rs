//! What PROJ would know better, had it the grid for a datum shift.

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::{self, NonNull};

use super::projection::{Crs, silence};

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
pub(crate) fn missing_grids(crs: &Crs, [west, south, east, north]: [f64; 4]) -> Option<MissingGrids> {
    silence();
    let area = if east - west < 360.0 {
        let [west, east] = [west, east].map(|longitude| longitude - 360.0 * ((longitude + 180.0) / 360.0).floor());
        [west, south, east, north]
    } else {
        [-180.0, south, 180.0, north]
    };
    let operations = Operations::new(&crs.definition, "EPSG:4326", area)?;
    let best = operations.get(0)?;
    if best.is_instantiable() {
        return None;
    }
    let others = (1..operations.count()).filter_map(|index| operations.get(index));
    let mut usable = others.filter(|operation| operation.is_instantiable() && !operation.is_ballpark());
    Some(MissingGrids {
        grids: best.absent_grids(),
        accuracy: best.accuracy(),
        without: usable.next().map(|operation| operation.accuracy()),
    })
}

/// PROJ's operations from one reference system to another, the best first, whether their grids are there or not.
struct Operations {
    context: Context,
    list: NonNull<proj_sys::PJ_OBJ_LIST>,
}

impl Operations {
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

/// A text of PROJ's, which lives as long as the operation that it is of.
fn text(of: *const c_char) -> String {
    if of.is_null() {
        return String::new();
    }
    // SAFETY: PROJ ends its texts with a zero.
    unsafe { CStr::from_ptr(of) }.to_string_lossy().into_owned()
}

#[cfg(test)]
#[path = "missing_grids_tests.rs"]
mod tests;
