#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use fastrand::Rng;

use super::*;

const SIZE: u32 = 9;

/// Two tiles from west to east, a metre from post to post.
fn grid() -> Grid {
    Grid::new([DVec2::ZERO, DVec2::new(16.0, 8.0)], 1.0, Some(SIZE)).unwrap()
}

/// Squares of 1.6 m over all of the grid and more, cut in two, with heights at random.
fn rough(random: &mut Rng) -> Piece {
    let (columns, rows) = (14, 9);
    let positions = (0..columns * rows).map(|index| {
        let plan = DVec2::new(f64::from(index % columns), f64::from(index / columns)) * 1.6 - 2.0;
        let shaken = plan + 0.4 * DVec2::new(random.f64(), random.f64());
        shaken.extend(10.0 * random.f64())
    });
    let corners = |index: u32| {
        let (a, b, c, d) = (index, index + 1, index + columns, index + columns + 1);
        [[a, b, d], [a, d, c]]
    };
    let squares = (0..columns * (rows - 1)).filter(|index| index % columns + 1 < columns);
    Piece {
        positions: positions.collect(),
        triangles: squares.flat_map(corners).collect(),
    }
}

fn posts(tile: UVec2, pieces: &[&Piece]) -> Posts {
    let mut posts = Posts::empty(&grid(), tile);
    pieces.iter().for_each(|piece| posts.add(piece));
    posts
}

#[test]
fn a_plane_is_what_it_was() {
    let corners = [(-1.0, -1.0), (30.0, -1.0), (-1.0, 30.0)];
    let plane = Piece {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 2.0 * x - y + 3.0)).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let posts = posts(UVec2::X, &[&plane]);
    for (index, &height) in (0..).zip(&posts.heights) {
        let (x, y) = (f64::from(index % SIZE) + 8.0, f64::from(index / SIZE));
        assert!(
            (f64::from(height) - (2.0 * x - y + 3.0)).abs() < 1e-5,
            "{x} {y}: {height}"
        );
    }
    assert!(posts.difference(&plane) < 1e-5);
    assert!((posts.steepest() - 5_f64.sqrt()).abs() < 1e-5);
}

#[test]
fn both_tiles_have_the_same_posts_where_they_meet_whatever_the_order() {
    let mut random = Rng::with_seed(5);
    let (one, other) = (rough(&mut random), rough(&mut random));
    let west = posts(UVec2::ZERO, &[&one, &other]);
    let east = posts(UVec2::X, &[&other, &one]);
    for row in 0..SIZE as usize {
        let (last, first) = (west.heights[row * 9 + 8], east.heights[row * 9]);
        assert_eq!(last.to_bits(), first.to_bits(), "row {row}");
        assert!(last.is_finite());
    }
}

#[test]
fn there_is_no_ground_in_holes() {
    let mut piece = rough(&mut Rng::with_seed(6));
    piece.triangles.retain(|&[a, ..]| piece.positions[a as usize].x < 4.0);
    let posts = posts(UVec2::ZERO, &[&piece]);
    assert!(posts.heights[0].is_finite() && posts.heights[8].is_nan());
    assert!(posts.difference(&piece) < 20.0);
}

/// By looking at many points of the surface.
#[test]
fn the_difference_is_the_largest_there_is_whichever_way_cells_are_cut() {
    let mut random = Rng::with_seed(7);
    for _ in 0..5 {
        let piece = rough(&mut random);
        let posts = posts(UVec2::ZERO, &[&piece]);
        let claimed = posts.difference(&piece);
        let mut seen = 0_f64;
        for &triangle in &piece.triangles {
            let [a, b, c] = piece.corners(triangle);
            for _ in 0..2000 {
                let (s, t) = (random.f64(), random.f64());
                // Many near edges and corners, where the largest is.
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let at = a + s.powi(3) * (b - a) + t.powi(3) * (c - a);
                seen = seen.max(by_hand(&posts, at));
            }
        }
        assert!(seen <= claimed + 1e-9, "{seen} {claimed}");
        assert!(seen > 0.9 * claimed, "{seen} {claimed}");
    }
}

/// Over the first tile, whose cells are those of whole metres.
fn by_hand(posts: &Posts, at: DVec3) -> f64 {
    if at.x < 0.0 || at.y < 0.0 || at.x >= 8.0 || at.y >= 8.0 {
        return 0.0;
    }
    let (column, row) = (at.x as usize, at.y as usize);
    let (u, v) = (at.x.fract(), at.y.fract());
    let post = |x: usize, y: usize| f64::from(posts.heights[(row + y) * 9 + column + x]);
    let [a, b, c, d] = [post(0, 0), post(1, 0), post(0, 1), post(1, 1)];
    let rising = if u > v {
        a + u * (b - a) + v * (d - b)
    } else {
        a + v * (c - a) + u * (d - c)
    };
    let falling = if u + v < 1.0 {
        a + u * (b - a) + v * (c - a)
    } else {
        d + (1.0 - u) * (c - d) + (1.0 - v) * (b - d)
    };
    let bilinear = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * c + u * d);
    [rising, falling, bilinear]
        .map(|height| (height - at.z).abs())
        .into_iter()
        .fold(0.0, f64::max)
}
