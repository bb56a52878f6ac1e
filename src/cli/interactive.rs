//! `fix --interactive`: a review at the terminal, one fix after another.

use std::collections::VecDeque;
use std::io::BufRead;

use crate::api::review::{HELP, HandEdit, Item, Preview, Review, ReviewOptions};
use crate::diagnostic::Diagnostic;
use crate::report::failure::Failure;
use crate::report::visible;
use crate::text::counted;

use super::args::CLEAN;
use super::output::{self, Progress};

/// Exit code where an error is left.
const LEFT: u8 = 1;

/// What can be answered.
const ANSWERS: &str = "\
y  make this fix
n  reject it; asks why, and the baseline remembers that
a  make all fixes of this kind
r  reject all fixes of this kind
l  later: look at it again at the end
e  edit the map yourself, in words
u  undo the last step
d  show what would be saved
w  write what was decided so far, and go on
q  ask whether to write, and end
?  this list
";

/// What came of an answer.
enum Next {
    /// The next fix.
    Go,
    /// The same one again.
    Stay,
    /// No further one.
    End,
}

/// Asks about each fix that needs a review; writes only what the user wants to be written.
pub fn run(options: ReviewOptions) -> Result<u8, Failure> {
    let progress = Progress::start("checking");
    let mut review = Review::open(options)?;
    drop(progress);
    let mut input = std::io::stdin().lock().lines().map_while(Result::ok);
    let mut asks = true;
    while asks {
        ask_about_each(&mut review, &mut input)?;
        asks = false;
        while review.is_unsaved() && !asks {
            match asked(&mut input, "Write this? [y,n,d,u] ")?.as_deref() {
                Some("y" | "yes") => said(review.save())?,
                Some("d") => output::print_patch(&review.diff())?,
                Some("u") => {
                    said(review.undo())?;
                    asks = true;
                }
                _ => {
                    output::print("nothing was written\n")?;
                    break;
                }
            }
        }
    }
    let [_, [errors, _]] = review.counts();
    Ok(if errors > 0 { LEFT } else { CLEAN })
}

fn ask_about_each(review: &mut Review, input: &mut impl Iterator<Item = String>) -> Result<(), Failure> {
    let mut put_off: VecDeque<usize> = VecDeque::new();
    loop {
        let open = to_review(review);
        let first = open.iter().find(|at| !put_off.contains(at)).copied();
        // What was put off comes again, once.
        let Some(item) = first.or_else(|| std::iter::from_fn(|| put_off.pop_front()).find(|at| open.contains(at)))
        else {
            return output::print(&format!("no fix that needs a review is left\n{}", summary(review)));
        };
        show(review, item, open.len())?;
        loop {
            let Some(answer) = asked(input, "Make it? [y,n,a,r,l,e,u,d,w,q,?] ")? else { return Ok(()) };
            match answered(review, item, &answer, (&mut put_off, input)) {
                Ok(Next::Go) => break,
                Ok(Next::Stay) => {}
                Ok(Next::End) => return output::print(&summary(review)),
                Err(failure) => output::tell_failure(&failure),
            }
        }
    }
}

/// The open fixes that are asked about: those that are not safe.
fn to_review(review: &Review) -> Vec<usize> {
    let open = review.open_items();
    review.items().filter(|(at, item)| !item.safe && open.contains(at)).map(|(at, _)| at).collect()
}

fn answered(
    review: &mut Review,
    item: usize,
    answer: &str,
    (put_off, input): (&mut VecDeque<usize>, &mut impl Iterator<Item = String>),
) -> Result<Next, Failure> {
    let done = |told: String| output::print(&format!("{}\n\n", visible(&told))).map(|()| Next::Go);
    match answer {
        "y" => review.accept(&[item]).and_then(done),
        "a" => review.accept(&review.alike(item)).and_then(done),
        "n" | "r" => {
            let items = if answer == "n" { vec![item] } else { review.alike(item) };
            let reason = asked(input, "Why not? ")?.unwrap_or_default();
            review.reject(&items, &reason).and_then(done)
        }
        "l" => {
            put_off.push_back(item);
            review.put_off(&[item]).and_then(done)
        }
        "e" => {
            let Some(words) = asked(input, &format!("{HELP}\nEdit: "))? else { return Ok(Next::End) };
            review.edit(&HandEdit::parse(&words)?).and_then(done)
        }
        "u" => {
            let told = review.undo()?;
            put_off.retain(|at| review.decision(*at).is_some());
            done(told)
        }
        "d" => output::print_patch(&review.diff()).map(|()| Next::Stay),
        "w" => said(review.save()).map(|()| Next::Stay),
        "q" => Ok(Next::End),
        _ => output::print(ANSWERS).map(|()| Next::Stay),
    }
}

fn said(told: Result<String, Failure>) -> Result<(), Failure> {
    output::print(&format!("{}\n", visible(&told?)))
}

/// Asks, and gives the answer without blanks around it; `None` at the end of the input.
fn asked(input: &mut impl Iterator<Item = String>, question: &str) -> Result<Option<String>, Failure> {
    output::print(question)?;
    Ok(input.next().map(|line| line.trim().to_owned()))
}

/// Shows a fix: what is wrong, what would be done, what that takes for granted, and what comes of it.
fn show(review: &mut Review, item: usize, left: usize) -> Result<(), Failure> {
    let preview = review.preview(item)?;
    let alike = review.alike(item).len();
    let Some((_, Item { finding, assumes, .. })) = review.items().nth(item) else { return Ok(()) };
    let mut text =
        format!("{}[{}] {} ({left} to review)\n", finding.severity, finding.code, visible(&finding.finding.message));
    let mut line = |name: &str, words: &str| text += &format!("  {name}: {}\n", visible(words));
    line("at", &place(finding));
    if let Some((_, item)) = review.items().nth(item) {
        line("fix", item.title());
    }
    line("takes for granted", assumes);
    let Preview { refused, also, changes, counts: [before, after], brings, planner, .. } = &preview;
    changes.iter().for_each(|one| line("changes", &format!("{}: {}", one.subject, one.facts.join("; "))));
    also.iter().for_each(|one| line("makes as well", one));
    brings.iter().for_each(|one| line("brings", one));
    for [then, now] in planner {
        line("Autoware before", then);
        line("Autoware after", now);
    }
    if let Some(why) = refused {
        line("fix would not keep it", why);
    }
    line("errors, warnings", &format!("{} → {}, {} → {}", before[0], after[0], before[1], after[1]));
    if alike > 1 {
        line("of this kind", &format!("{alike} fixes"));
    }
    output::print(&text)
}

fn place(finding: &Diagnostic) -> String {
    let place = finding.lonlat.map(|at| format!(", {:.7}, {:.7}", at.lat, at.lon)).unwrap_or_default();
    format!("{}{place}", finding.finding.subject)
}

fn summary(review: &Review) -> String {
    let [before, after] = review.counts();
    let steps = counted(review.steps().len(), "step");
    format!("{steps}: errors {} → {}, warnings {} → {}\n", before[0], after[0], before[1], after[1])
}
