//! Rows of indices of differing lengths in two flat arrays.

/// Compressed sparse rows: row `i` is `items[starts[i]..starts[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompressedRows {
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Default for CompressedRows {
    fn default() -> Self {
        Self {
            starts: vec![0],
            items: Vec::new(),
        }
    }
}

impl CompressedRows {
    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = u32>) {
        self.items.extend(row);
        self.starts.push(self.items.len());
    }

    /// How many rows there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One row.
    #[must_use]
    pub fn row(&self, index: u32) -> &[u32] {
        let index = index as usize;
        &self.items[self.starts[index]..self.starts[index + 1]]
    }

    /// All rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = &[u32]> + Clone {
        self.starts.windows(2).map(|ends| &self.items[ends[0]..ends[1]])
    }

    /// Pairs of a row below `row_count` and an item, sorted by row; items of one row stay in the order of the pairs (a
    /// counting sort).
    pub fn sorted(row_count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        // Where rows begin, two places on: as they are filled, each start moves on to where the next row begins.
        let mut starts = vec![0; row_count + 2];
        for (row, _) in pairs.clone() {
            starts[row as usize + 2] += 1;
        }
        for row in 2..starts.len() {
            starts[row] += starts[row - 1];
        }
        let mut items = vec![0; starts[row_count + 1]];
        for (row, item) in pairs {
            let place = &mut starts[row as usize + 1];
            items[*place] = item;
            *place += 1;
        }
        starts.pop();
        Self { starts, items }
    }

    /// As many rows the other way round: `i` is in row `j` where `j` was in row `i`. Its rows grow.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let pairs = (0..).zip(self.rows());
        Self::sorted(
            self.len(),
            pairs.flat_map(|(index, row)| row.iter().map(move |&item| (item, index))),
        )
    }

    /// Bytes in memory, about.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.items)
    }

    /// The items of all rows, one row after the other.
    #[must_use]
    pub fn into_items(self) -> Vec<u32> {
        self.items
    }
}
