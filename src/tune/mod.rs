//! Tuning: parameters that do well on some ducts, held against the default on ducts that the search never saw.
//!
//! In data-flow order:
//!
//! - [`jacobi`], [`cma_es`], [`restarts`]: the evolution strategy; - [`proposer`]: it, and the baselines, as one that is asked and told;
//! - [`candidate`]: a point of the unit box as settings of a scenario; - [`objective`]: what its runs come to;
//! - [`search`]: candidates, generation by generation, each a sweep of its own; - [`comparison`]: the find against the default;
//! - [`trials`]: a row a candidate; - [`summary`]: what it comes to.

pub mod candidate;
pub mod cma_es;
pub mod comparison;
pub mod jacobi;
pub mod objective;
pub mod proposer;
pub mod restarts;
pub mod search;
pub mod summary;
pub mod trials;
