//! Heights under voids: those around them, spread smoothly. After S. Gortler and others, *The Lumigraph*, 1996, 3.3 (pull-push): averages
//! of ever coarser grids, put where finer ones have nothing. No height that comes out is beyond those that went in.

/// Fills what is none in a square of `size` a side, a power of two; where everything is none, all of it stays so.
pub(super) fn fill_voids(heights: &mut [Option<f64>], size: usize) {
    if size == 1 || heights.iter().all(Option::is_some) {
        return;
    }
    let half = size / 2;
    let mut coarse: Vec<Option<f64>> = (0..half * half).map(|cell| average(heights, size, cell)).collect();
    fill_voids(&mut coarse, half);
    for (index, height) in heights.iter_mut().enumerate().filter(|(_, height)| height.is_none()) {
        *height = between(&coarse, half, [index % size, index / size]);
    }
}

/// Of the four that a cell of the coarser grid covers, as far as they are there.
fn average(heights: &[Option<f64>], size: usize, cell: usize) -> Option<f64> {
    let (x, y) = (cell % (size / 2) * 2, cell / (size / 2) * 2);
    let four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| heights[(y + down) * size + x + right]);
    let count = four.iter().flatten().count();
    (count > 0).then(|| four.iter().flatten().sum::<f64>() / count as f64)
}

/// Bilinear between the middles of the four nearest cells of the coarser grid; at its rim, the nearest.
fn between(coarse: &[Option<f64>], size: usize, fine: [usize; 2]) -> Option<f64> {
    let lines = fine.map(|position| {
        let at = (position as f64 - 0.5) / 2.0;
        let first = at.floor();
        let clamp = |line: f64| line.clamp(0.0, (size - 1) as f64) as usize;
        [(clamp(first), 1.0 - (at - first)), (clamp(first + 1.0), at - first)]
    });
    let mut sum = 0.0;
    for (x, across) in lines[0] {
        for (y, down) in lines[1] {
            sum += coarse[y * size + x]? * across * down;
        }
    }
    Some(sum)
}
