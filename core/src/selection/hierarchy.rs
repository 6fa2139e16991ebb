//! What the selection asks of what it selects from.

use std::hash::Hash;

use crate::selection::oriented_box::OrientedBox;

/// A level of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// How far it may be from the source.
    pub error: f64,
    /// Triangles of it.
    pub triangles: u64,
    /// What it takes in memory.
    pub bytes: u64,
}

/// Surfaces of which some are replaced by several finer ones, at no more than four sides of each another one.
///
/// A node's finest level is what its children show together at their coarsest; so their errors are no larger than its own. Nodes meet across a side if both show it
/// coarse, or both fine; fine sides of a node meet the coarse ones of a neighbour's children. Only a finest level has
/// fine sides.
pub trait Hierarchy {
    /// Names a node. Of two nodes that matter equally, the smaller comes first.
    type Node: Copy + Ord + Hash;

    /// The nodes that have no parent.
    fn roots(&self) -> impl Iterator<Item = Self::Node>;

    /// The node that this one is a part of.
    fn parent(&self, node: Self::Node) -> Option<Self::Node>;

    /// The parts of a node; none, or all there are of it.
    fn children(&self, node: Self::Node) -> impl Iterator<Item = Self::Node>;

    /// The nodes of the same depth across the four sides. What is across a side has this node across the side that is two
    /// further on.
    fn neighbours(&self, node: Self::Node) -> [Option<Self::Node>; 4];

    /// Holds the node and everything below it.
    fn bounds(&self, node: Self::Node) -> OrientedBox;

    /// At least one, coarsest first; of a node that is not loaded, what is known of its finest level is enough.
    fn levels(&self, node: Self::Node) -> &[Level];
}
