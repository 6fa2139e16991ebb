//! What the encoder knows of the splits to come: which vertex can split now, and how.

use terrain_core::SurfacePartition;

use super::collapses::{Collapses, NONE};
use super::level::SplitSource;
use super::ring::{Cuts, Ring, Spoke};
use super::split::Split;

/// Splits of one level after the other, each as soon as those that it needs were made.
pub(super) struct Schedule<'a> {
    partition: &'a SurfacePartition,
    collapses: &'a Collapses,
    /// The level that is being coded.
    pub(super) level: u32,
    /// The partition's number of each vertex of the surface that grows.
    pub(super) originals: Vec<u32>,
    /// For each vertex of the partition the collapse into it that is undone next.
    next: Vec<u32>,
    /// For each collapse how many others are to be undone before.
    waiting: Vec<u32>,
}

impl<'a> Schedule<'a> {
    pub(super) fn new(partition: &'a SurfacePartition, collapses: &'a Collapses, base: Vec<u32>) -> Self {
        let dag = &collapses.dag;
        Self {
            partition,
            collapses,
            level: 0,
            originals: base,
            next: collapses.last_into.clone(),
            waiting: (0..dag.len() as u32)
                .map(|collapse| dag.split_constraints(collapse).len() as u32)
                .collect(),
        }
    }

    fn place(&self, ring: &Ring, original: Option<u32>) -> usize {
        let is_it = |spoke: &Spoke| Some(self.originals[spoke.vertex as usize]) == original;
        ring.spokes.iter().position(is_it).unwrap_or_default()
    }
}

impl SplitSource for Schedule<'_> {
    fn splits(&self, vertex: u32) -> bool {
        let collapse = self.next[self.originals[vertex as usize] as usize];
        collapse != NONE
            && self.waiting[collapse as usize] == 0
            && self.collapses.undos[collapse as usize].level == self.level
    }

    fn split(&self, vertex: u32, ring: &Ring) -> Split {
        let undo = &self.collapses.undos[self.next[self.originals[vertex as usize] as usize] as usize];
        Split {
            cuts: Cuts {
                side: undo.side,
                first: self.place(ring, undo.cuts[0]),
                second: self.place(ring, undo.cuts[1]),
            },
            blue: self.partition.positions[undo.blue as usize],
            red: undo.red_before,
        }
    }

    fn performed(&mut self, vertex: u32) {
        let red = self.originals[vertex as usize] as usize;
        let collapse = self.next[red];
        let undo = &self.collapses.undos[collapse as usize];
        for &needed in self.collapses.dag.constraints(collapse) {
            self.waiting[needed as usize] -= 1;
        }
        self.next[red] = undo.earlier;
        self.originals.push(undo.blue);
    }
}
