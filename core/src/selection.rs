//! Which nodes of a hierarchy of surfaces to draw, each at which level and which of its sides fine: a restricted quadtree by
//! projected error, without a hole whatever has been loaded.
//!
//! The surfaces are apart from the rule: it knows boxes, errors and who is beside whom ([`hierarchy`]). The page has the same
//! rule in TypeScript (`server/web/src/select.ts`); both answer the cases in `tests/selection`, bit for bit.
//!
//! Whether to refine a node is asked by the certified error of its finest level, as Lindstrom and Pascucci do for single
//! vertices (Terrain Simplification Simplified, 2002); what stands here is for whole tiles, whose sides fit together if
//! they are at most one depth apart.

pub mod camera;
pub mod hierarchy;
pub mod oriented_box;
mod refinements;
mod scene;
pub mod select;
