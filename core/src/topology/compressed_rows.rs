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
    pub fn rows(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|ends| &self.items[ends[0]..ends[1]])
    }

    /// As many rows the other way round: `i` is in row `j` where `j` was in row `i`. Its rows grow.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut starts = vec![0; self.starts.len()];
        for &item in &self.items {
            starts[item as usize + 1] += 1;
        }
        for row in 1..starts.len() {
            starts[row] += starts[row - 1];
        }
        let mut fill = starts.clone();
        let mut items = vec![0; self.items.len()];
        for (index, row) in (0_u32..).zip(self.rows()) {
            for &item in row {
                items[fill[item as usize]] = index;
                fill[item as usize] += 1;
            }
        }
        Self { starts, items }
    }
}
