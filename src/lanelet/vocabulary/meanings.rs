//! What somebody meant who wrote another word of the same meaning: `road_edge` for `road_border`, `rgy` for `red_yellow_green`.

use rustc_hash::FxHashMap;

use super::table::Words;

/// Known words by what people write in their place.
#[derive(Debug, Default)]
pub struct Meanings {
    /// By the spelling without what divides its parts.
    by_spelling: FxHashMap<String, Vec<String>>,
    /// The same with the parts in another order.
    by_other_order: FxHashMap<String, Vec<String>>,
    /// By the initials of the parts, sorted.
    by_initials: FxHashMap<String, Vec<String>>,
    idle: Vec<String>,
}

/// Words of more parts than these are not said in another order.
const MOST_EXCHANGED: usize = 3;

impl Meanings {
    pub fn new(words: &Words) -> Self {
        let mut meanings = Self { idle: words.idle.words.clone(), ..Self::default() };
        let lists = words.types.iter().flat_map(|list| list.names.iter().chain(list.subtypes.iter().flatten()));
        let paint = words.paint.words.iter();
        let values = words.key.iter().flat_map(|key| &key.values);
        for word in lists.chain(paint).chain(values) {
            meanings.learn(words, word, true);
        }
        // A key of one part is too short a word: a `zone` need not be a `region`.
        let keys = words.key.iter().flat_map(|key| words.written_out(key));
        for key in keys.filter(|key| parts(key).len() > 1) {
            meanings.learn(words, &key, false);
        }
        for one in &words.meant {
            for said in &one.said {
                add(&mut meanings.by_spelling, parts(said).concat(), &one.word);
            }
        }
        meanings
    }

    /// Adds a known word with each of its parts said in all ways.
    fn learn(&mut self, words: &Words, word: &str, has_initials: bool) {
        let alike = |part: &String| -> Vec<String> {
            let groups = words.alike.words.iter().map(|group| group.iter().map(|one| parts(one).concat()));
            let groups = groups.filter(|group| group.clone().any(|one| one == *part));
            std::iter::once(part.clone()).chain(groups.flatten().filter(|other| other != part)).collect()
        };
        let mut said = vec![Vec::new()];
        for part in &parts(word) {
            let ways = alike(part);
            said = said
                .iter()
                .flat_map(|before| ways.iter().map(|way| [before.as_slice(), std::slice::from_ref(way)].concat()))
                .collect();
        }
        for one in said {
            if has_initials && one.len() > 1 {
                add(&mut self.by_initials, initials(&one), word);
            }
            add(&mut self.by_spelling, one.concat(), word);
            for order in orders(&one) {
                add(&mut self.by_other_order, order.concat(), word);
            }
        }
    }

    /// The one of these words that was meant.
    pub fn of(&self, said: &str, words: impl Iterator<Item = &'static str>) -> Option<&'static str> {
        let (said, words) = (parts(said).concat(), words.collect::<Vec<_>>());
        let meant = |by: &FxHashMap<String, Vec<String>>| only(by.get(&said)?, words.iter().copied());
        meant(&self.by_spelling).or_else(|| meant(&self.by_other_order))
    }

    /// The one of these words of which somebody wrote the initials, in whatever order.
    pub fn initials(&self, said: &str, words: impl Iterator<Item = &'static str>) -> Option<&'static str> {
        let letters: Vec<String> = said.to_lowercase().chars().map(String::from).collect();
        only(self.by_initials.get(&initials(&letters))?, words)
    }

    /// A word without the parts that say nothing; `None` where it has none of them, or nothing else.
    pub fn without_idle(&self, said: &str) -> Option<String> {
        let parts = parts(said);
        let telling: Vec<String> = parts.iter().filter(|part| !self.idle.contains(part)).cloned().collect();
        (!telling.is_empty() && telling.len() < parts.len()).then(|| telling.join("_"))
    }
}

fn add(to: &mut FxHashMap<String, Vec<String>>, said: String, word: &str) {
    let words = to.entry(said).or_default();
    if !words.iter().any(|known| known == word) {
        words.push(word.to_owned());
    }
}

/// The one word that is in both.
fn only(meant: &[String], mut words: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    let first = words.find(|word| meant.iter().any(|known| known == word))?;
    words.all(|word| word == first || !meant.iter().any(|known| known == word)).then_some(first)
}

/// The parts of a word in small letters; what is plural is made singular, and `laneChange` has two.
fn parts(word: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut after_small = false;
    for letter in word.chars() {
        if matches!(letter, '_' | '-' | ' ' | ':') || letter.is_uppercase() && after_small {
            parts.push(String::new());
        }
        after_small = letter.is_lowercase();
        if let Some(part) = parts.last_mut().filter(|_| letter.is_alphanumeric()) {
            part.extend(letter.to_lowercase());
        }
    }
    parts.retain(|part| !part.is_empty());
    for part in &mut parts {
        if part.ends_with('s') && !part.ends_with("ss") && part.len() > 3 {
            part.pop();
        }
    }
    parts
}

fn initials(parts: &[String]) -> String {
    let mut letters: Vec<char> = parts.iter().filter_map(|part| part.chars().next()).collect();
    letters.sort_unstable();
    letters.into_iter().collect()
}

/// A word's parts in its own and, where they are few, in all other orders.
fn orders(parts: &[String]) -> Vec<Vec<String>> {
    if parts.len() > MOST_EXCHANGED {
        return vec![parts.to_vec()];
    }
    let mut orders = vec![Vec::new()];
    for _ in parts {
        orders = orders
            .iter()
            .flat_map(|order: &Vec<usize>| {
                let free = (0..parts.len()).filter(|at| !order.contains(at));
                free.map(|at| [order.as_slice(), &[at]].concat()).collect::<Vec<_>>()
            })
            .collect();
    }
    orders.iter().map(|order| order.iter().filter_map(|at| parts.get(*at).cloned()).collect()).collect()
}
