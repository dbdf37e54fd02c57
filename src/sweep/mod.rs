//! Sweeps: a list of cases, each named by its hash, run anywhere, in any order, as often as it takes, and one table at the end.
//!
//! In data-flow order:
//!
//! - [`design`]: factors to points; - [`case`]: points and replicates to cases, each with its hash;
//! - [`plan`]: all of it as a document that stands beside the results; - [`store`]: where these are: a folder, or an object store;
//! - [`single_case`]: one case to its [`outcome`]; - [`part`]: outcomes as a file that tells when it was damaged;
//! - [`ledger`]: what is done; - [`work`]: what is not, on all cores;
//! - [`pass_rate`]: Wilson intervals, and when a point has been repeated enough;
//! - [`table`]: a row a case; - [`figures`]: what it comes to, by point, factor and level; - [`repeat`]: the command for one case.

pub mod case;
pub mod design;
pub mod figures;
pub mod ledger;
pub mod outcome;
pub mod part;
pub mod pass_rate;
pub mod plan;
pub mod repeat;
pub mod single_case;
pub mod store;
pub mod table;
pub mod work;
