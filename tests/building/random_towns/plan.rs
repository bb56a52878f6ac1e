//! The nodes and ways of a town, in metres, and how to put more of them onto what is there.

use crate::common::drawing::Drawing;

/// Metres east and north.
pub type Place = [f64; 2];

pub struct Node {
    pub place: Place,
    pub tags: String,
}

/// A way; its nodes stand in the direction of its block.
pub struct Way {
    pub nodes: Vec<usize>,
    pub tags: String,
    /// Whether it is written in the other direction.
    pub reversed: bool,
}

/// A turn restriction over ways, each of which begins where the one before it ends; over this node if they are two.
pub struct Restriction {
    pub ways: Vec<usize>,
    pub node: Option<usize>,
    pub value: &'static str,
}

#[derive(Default)]
pub struct Plan {
    pub nodes: Vec<Node>,
    pub ways: Vec<Way>,
    pub restrictions: Vec<Restriction>,
}

/// Two nodes nearer than this, metres, are one.
const SAME_NODE: f64 = 1.0;
/// Ways without a common node are drawn at least so far apart, metres.
const LEAST_GAP: f64 = 4.0;
/// Metres of a degree of latitude.
const DEGREE: f64 = 111_200.0;

pub fn plus(a: Place, b: Place, times: f64) -> Place {
    [a[0] + b[0] * times, a[1] + b[1] * times]
}

pub fn between(a: Place, b: Place, part: f64) -> Place {
    plus(a, [b[0] - a[0], b[1] - a[1]], part)
}

pub fn distance(a: Place, b: Place) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The unit vector of this heading, radians from the east.
pub fn heading(angle: f64) -> Place {
    [angle.cos(), angle.sin()]
}

pub fn angle(from: Place, to: Place) -> f64 {
    (to[1] - from[1]).atan2(to[0] - from[0])
}

/// Whether two segments cross, or one ends within this distance of the other, metres.
fn segments_within([a, b]: [Place; 2], [c, d]: [Place; 2], far: f64) -> bool {
    let side = |p: Place, q: Place, r: Place| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let cross = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
    let from = |p: Place, q: Place, r: Place| {
        let along = (r[0] - p[0]) * (q[0] - p[0]) + (r[1] - p[1]) * (q[1] - p[1]);
        distance(between(p, q, (along / distance(p, q).powi(2)).clamp(0.0, 1.0)), r)
    };
    cross || [from(a, b, c), from(a, b, d), from(c, d, a), from(c, d, b)].into_iter().any(|near| near < far)
}

impl Plan {
    pub fn node(&mut self, place: Place, tags: &str) -> usize {
        self.nodes.push(Node { place, tags: tags.to_owned() });
        self.nodes.len() - 1
    }

    pub fn way(&mut self, nodes: Vec<usize>, tags: &str) -> usize {
        self.ways.push(Way { nodes, tags: tags.to_owned(), reversed: false });
        self.ways.len() - 1
    }

    /// A way over these places, from a node and perhaps to one.
    pub fn path(&mut self, from: usize, places: &[Place], to: Option<usize>, tags: &str) -> usize {
        let mut nodes = vec![from];
        nodes.extend(places.iter().map(|place| self.node(*place, "")));
        nodes.extend(to);
        self.way(nodes, tags)
    }

    /// Adds another plan, so far to the east and north; its nodes are numbered from the returned number on.
    pub fn put_beside(&mut self, other: &Self, by: Place) -> usize {
        let first = self.nodes.len();
        let moved = other.nodes.iter().map(|node| Node { place: plus(node.place, by, 1.0), tags: node.tags.clone() });
        self.nodes.extend(moved);
        self.ways.extend(other.ways.iter().map(|way| Way {
            nodes: way.nodes.iter().map(|node| first + node).collect(),
            tags: way.tags.clone(),
            reversed: way.reversed,
        }));
        first
    }

    /// Moves everything so far to the east and north.
    pub fn shift(&mut self, by: Place) {
        self.nodes.iter_mut().for_each(|node| node.place = plus(node.place, by, 1.0));
    }

    pub fn place(&self, node: usize) -> Place {
        self.nodes[node].place
    }

    /// Length of a way, metres.
    pub fn length(&self, way: usize) -> f64 {
        self.ways[way].nodes.windows(2).map(|pair| distance(self.place(pair[0]), self.place(pair[1]))).sum()
    }

    /// The node of a way at this distance from its start, metres; a new one where none is near. Returns where it is in the way.
    pub fn along(&mut self, way: usize, mut far: f64) -> usize {
        let nodes = self.ways[way].nodes.clone();
        for (i, pair) in nodes.windows(2).enumerate() {
            let [a, b] = [self.place(pair[0]), self.place(pair[1])];
            let piece = distance(a, b);
            if far < SAME_NODE && i > 0 {
                return i;
            }
            if far + SAME_NODE < piece {
                let node = self.node(between(a, b, far / piece), "");
                self.ways[way].nodes.insert(i + 1, node);
                return i + 1;
            }
            far -= piece;
        }
        nodes.len() - 1
    }

    /// Takes the ways back that were drawn when there were already so many, if one lies over another without a common node.
    pub fn keep_apart(&mut self, before: usize) {
        let over = (before..self.ways.len()).any(|new| (0..new).any(|old| self.lie_over(new, old)));
        if over {
            self.ways.truncate(before);
        }
    }

    fn lie_over(&self, new: usize, old: usize) -> bool {
        let [new, old] = [new, old].map(|way| &self.ways[way]);
        if !new.tags.starts_with("highway") || !old.tags.starts_with("highway") {
            return false;
        }
        let ends = |pair: &[usize]| [self.place(pair[0]), self.place(pair[1])];
        new.nodes.windows(2).any(|a| {
            let apart = |b: &&[usize]| !a.iter().any(|node| b.contains(node));
            let near = |b: &[usize]| segments_within(ends(a), ends(b), LEAST_GAP);
            old.nodes.windows(2).filter(apart).any(near)
        })
    }

    /// Ends a way at one of its nodes; returns the way of the rest, if there is one.
    pub fn split(&mut self, way: usize, at: usize) -> Option<usize> {
        if at == 0 || at + 1 >= self.ways[way].nodes.len() {
            return None;
        }
        let (rest, tags) = (self.ways[way].nodes[at..].to_vec(), self.ways[way].tags.clone());
        self.ways[way].nodes.truncate(at + 1);
        self.ways.push(Way { nodes: rest, tags, reversed: self.ways[way].reversed });
        Some(self.ways.len() - 1)
    }

    /// The town turned by an angle, where people drive on this side: its data as XML.
    pub fn xml(&self, turned: f64, left_hand: bool) -> String {
        let [latitude, longitude] = if left_hand { [51.5, -1.5] } else { [48.1, 11.5] };
        let (sine, cosine) = turned.sin_cos();
        let mut xml = Drawing::default();
        for (id, node) in (1..).zip(&self.nodes) {
            let [x, y] = node.place;
            let (east, north) = (x * cosine - y * sine, x * sine + y * cosine);
            let narrow = f64::to_radians(latitude).cos();
            let place = [latitude + north / DEGREE, longitude + east / DEGREE / narrow];
            xml.node(id, place.map(|degrees| format!("{degrees:.7}")), &node.tags);
        }
        for (id, way) in (1..).zip(&self.ways) {
            let mut nodes: Vec<usize> = way.nodes.iter().map(|node| node + 1).collect();
            if way.reversed {
                nodes.reverse();
            }
            // The lane in the middle is for those who turn to the far side.
            let far = if left_hand { "both_ways=right" } else { "both_ways=left" };
            xml.way(id, nodes, &way.tags.replace("both_ways=left", far));
        }
        for (id, Restriction { ways, node, value }) in (1..).zip(&self.restrictions) {
            let last = ways.len() - 1;
            let role = |at: usize| match at {
                0 => "from",
                _ if at == last => "to",
                _ => "via",
            };
            let ways = ways.iter().enumerate().map(|(at, way)| (role(at), 'w', *way as i64 + 1));
            let members: Vec<_> = ways.chain(node.map(|node| ("via", 'n', node as i64 + 1))).collect();
            xml.members(id, &members, &format!("type=restriction restriction={value}"));
        }
        xml.xml()
    }
}
