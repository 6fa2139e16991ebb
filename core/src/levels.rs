//! Levels of detail: a log of collapses becomes a Surface Partition, of which every level is a prefix, and a graph by which
//! any part of the surface is refined alone.
//!
//! | paper section | module |
//! | --- | --- |
//! | Surface Partitions §2.1 representatives, §2.2 levels | [`replay`], [`partition`] |
//! | Surface Partitions §2.2 changing the level, path compression | [`level_view`] |
//! | Surface Partitions §2.3 moving red vertices, attributes | [`attribute`] |
//! | Surface Partitions §2.4 collapse logs of any simplifier | [`collapse_log`], [`collapse_list`] |
//! | Surface Partitions §3 graph of the collapses | [`dag`] |
//! | Surface Partitions §3 local levels of detail, queues | [`adaptive_surface`], [`refinement_queues`], [`view_error`], [`view_refinement`] |

pub mod adaptive_surface;
pub mod attribute;
pub mod collapse_list;
pub mod collapse_log;
pub mod dag;
pub mod level_view;
pub mod partition;
pub mod refinement_queues;
pub mod replay;
pub mod view_error;
pub mod view_refinement;
