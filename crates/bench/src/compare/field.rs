//! The engines of a case with their trees.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::{Log, builds};
use crate::Failure;
use crate::engine::{Class, Crew, Engine, Tree};
use crate::measure::memory;
use crate::report::Row;
use crate::soup::Soup;

/// An engine with its tree.
pub(crate) struct Entrant {
    /// Name and settings.
    pub(crate) name: String,
    /// What the tree was built for.
    pub(crate) class: Class,
    /// Whether it promises that no ray slips between triangles.
    pub(crate) robust: bool,
    /// The tree.
    pub(crate) tree: Box<dyn Tree>,
}

/// Builds a tree with each engine, on one thread, and weighs it. Who cannot is left out, and it is said why.
pub(crate) fn build(
    case: &str,
    engines: &[&dyn Engine],
    soup: &Soup,
    log: &mut Log,
    rows: &mut Vec<Row>,
) -> Result<Vec<Entrant>, Failure> {
    let crew = Crew::new(1)?;
    let mut field = Vec::new();
    for engine in engines {
        let name = engine.name().to_owned();
        let built = guarded(|| {
            let mut ready = engine.prepare(soup)?;
            ready.renew()?;
            let (tree, held) = memory::count(|| ready.build(&crew));
            Ok((tree?, held))
        });
        match built {
            Ok((tree, held)) => {
                if !engine.shares_builds() {
                    rows.extend(builds::weighed(case, *engine, &*tree, held, soup));
                }
                field.push(Entrant { name, class: engine.class(), robust: engine.is_robust(), tree });
            }
            Err(failure) => log.say(&format!("  {name} is left out: {failure}")),
        }
    }
    Ok(field)
}

/// Says what is known about the trees: cost and overlap tell good trees from good kernels.
pub(crate) fn describe(field: &[Entrant], log: &mut Log) {
    for entrant in field {
        let facts = entrant.tree.facts();
        if let (Some(cost), Some(overlap)) = (facts.cost, facts.overlap) {
            log.say(&format!(
                "  {:<22} its tree: cost {cost:.2} by its own formula, overlap {overlap:.3}",
                entrant.name
            ));
        }
    }
}

/// Runs what may fail or panic.
pub(crate) fn guarded<R>(job: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|_| Err("it panicked".into()))
}
