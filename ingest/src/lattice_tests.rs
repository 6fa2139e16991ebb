use super::*;

const CELL: f64 = 1.0 / 3600.0;

fn lattice(steepest_step: f64, max_error: f64) -> Lattice {
    let demand = Demand {
        cell: CELL,
        max_error,
        steepest_step,
        farthest_height: 4000.0,
    };
    Lattice::new(12, demand)
}

#[test]
fn a_gentle_surface_has_32_768_units_in_a_tile_and_a_cliff_as_many_as_rounding_across_it_needs() {
    assert_eq!(lattice(30.0, 5.0).leaf_bits, 15);
    let cliff = lattice(10_000.0, 5.0);
    let units_in_a_cell = CELL / cliff.degrees_per_unit();
    // Half a unit along a column and half a one along a row.
    assert!(10_000.0 / units_in_a_cell <= 0.25 * 5.0, "{units_in_a_cell}");
    assert!(2.0 * 10_000.0 / units_in_a_cell > 0.25 * 5.0, "{units_in_a_cell}");
}

#[test]
fn no_demand_is_beyond_what_the_formats_take() {
    let finest = lattice(1e30, 1e-9);
    assert_eq!((finest.leaf_bits, finest.extent_bits(0)), (28, 40));
    let demand = Demand {
        cell: CELL,
        max_error: 1e-9,
        steepest_step: 0.0,
        farthest_height: 3.4e38,
    };
    let lattice = Lattice::new(12, demand);
    assert!(demand.farthest_height / lattice.height_step() < f64::from(i32::MAX));
}
