//! What lies between the streets of a random town, and beside them: car parks, service loops, slip lanes, ramps and the like.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::plan::{Place, angle, between, distance, heading, plus};
use super::streets::Grid;

/// A place on a street from which something leads into a quarter.
struct Mouth {
    block: usize,
    /// In the block's way.
    at: usize,
    node: usize,
    /// Into the quarter, and along the block, radians.
    inward: f64,
    along: f64,
}

impl Grid {
    /// Draws what is in the quarters and at the crossings.
    pub fn furnish(&mut self) {
        let quarters = self.side - 1;
        for (x, y) in (0..quarters).flat_map(|x| (0..quarters).map(move |y| (x, y))) {
            self.apart(|town| match town.dice.below(10) {
                0 | 1 => town.car_park(x, y),
                2 => town.service_loop(x, y),
                3 => town.lollipop(x, y),
                4 => town.diagonal(x, y),
                5 => town.hairpin(x, y),
                6 => town.alley(x, y),
                _ => {}
            });
            for _ in 0..self.dice.below(3) {
                self.apart(|town| town.driveway(x, y));
            }
        }
        for crossing in 0..self.crossings.len() {
            if self.dice.chance(0.2) {
                self.apart(|town| town.slip_lane(crossing / town.side, crossing % town.side));
            }
            if !self.crossings[crossing].ring.is_empty() && self.dice.chance(0.4) {
                self.apart(|town| town.arm_of_roundabout(crossing));
            }
        }
        for block in 0..self.blocks.len() {
            match self.dice.below(12) {
                0 => self.bus_bay(block),
                1 | 2 => self.crosswalk(block),
                3 | 4 => self.between_carriageways(block),
                _ => {}
            }
        }
        if self.dice.chance(0.4) {
            self.apart(Self::motorway);
        }
    }

    /// Draws something, and takes it back where it lies over something else.
    fn apart(&mut self, draw: impl FnOnce(&mut Self)) {
        let before = self.plan.ways.len();
        draw(self);
        self.plan.keep_apart(before);
    }

    fn block_of(&self, key: (bool, usize, usize, usize)) -> Option<usize> {
        self.blocks.iter().position(|block| block.key == key)
    }

    /// A place on a side of a quarter: 0 is the southern side, 1 the eastern, 2 the northern, 3 the western one.
    fn mouth(&mut self, (x, y): (usize, usize), side: usize, part: f64) -> Option<Mouth> {
        let (north, at, block) = [(false, y, x), (true, x + 1, y), (false, y + 1, x), (true, x, y)][side];
        let inner = |carriageway| self.block_of((north, at, block, carriageway));
        let block = if side == 0 || side == 3 { inner(1).or_else(|| inner(0)) } else { inner(0) }?;
        let way = self.blocks[block].way;
        let length = self.plan.length(way);
        if length < 40.0 {
            return None;
        }
        let at = self.plan.along(way, length * part);
        let nodes = &self.plan.ways[way].nodes;
        let (node, next) = (nodes[at], nodes[(at + 1).min(nodes.len() - 1)]);
        let along = angle(self.plan.place(nodes[at - 1]), self.plan.place(next));
        let inward = along + if side == 0 || side == 1 { FRAC_PI_2 } else { -FRAC_PI_2 };
        // The eastern street runs to the north, and the quarter is to its left.
        Some(Mouth { block, at, node, inward, along })
    }

    fn any_mouth(&mut self, x: usize, y: usize) -> Option<Mouth> {
        let (side, part) = (self.dice.below(4), self.dice.between(0.25, 0.75));
        self.mouth((x, y), side, part)
    }

    /// A ring of aisles with cross aisles, entered from one street or two.
    fn car_park(&mut self, x: usize, y: usize) {
        let Some(mouth) = self.any_mouth(x, y) else { return };
        let from = self.plan.place(mouth.node);
        let into = mouth.inward + self.dice.between(-0.7, 0.7);
        let deep = self.dice.between(7.0, 16.0);
        let entrance = plus(from, heading(into), deep);
        let (wide, far) = (self.dice.between(0.2, 0.35) * self.spacing, self.dice.between(0.15, 0.4) * self.spacing);
        let (aside, turned) = (self.dice.between(0.2, 0.8), mouth.inward + self.dice.between(-0.2, 0.2));
        let corner = |right: f64, up: f64| {
            plus(plus(entrance, heading(turned - FRAC_PI_2), wide * (right - aside)), heading(turned), far * up)
        };
        let aisles = 1 + self.dice.below(3);
        let rungs: Vec<f64> = (0..=aisles).map(|i| i as f64 / aisles as f64).collect();
        let first = self.plan.node(entrance, "");
        let mut sides: [Vec<usize>; 2] = [Vec::new(), Vec::new()];
        for (side, right) in [0.0, 1.0].into_iter().enumerate() {
            for up in &rungs {
                let jitter = [self.dice.between(-1.0, 1.0), self.dice.between(-1.0, 1.0)];
                sides[side].push(self.plan.node(plus(corner(right, *up), jitter, 1.0), ""));
            }
        }
        let mut ring = vec![first];
        ring.extend(&sides[1]);
        ring.extend(sides[0].iter().rev());
        ring.push(first);
        let one_way = if self.dice.chance(0.3) { " oneway=yes" } else { "" };
        self.plan.way(ring, &format!("highway=service{one_way}"));
        for (left, right) in sides[0].iter().zip(&sides[1]).take(aisles).skip(1) {
            let one_way = self.dice.pick(&["", "", " oneway=yes"]);
            self.plan.way(vec![*left, *right], &format!("highway=service service=parking_aisle{one_way}"));
        }
        self.driveway_to(mouth.node, first);
        if let Some(exit) = self.any_mouth(x, y).filter(|_| self.dice.chance(0.4)) {
            let near = |node: &&usize| distance(self.plan.place(**node), self.plan.place(exit.node));
            let last = *sides.iter().flatten().min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
            if distance(self.plan.place(last), self.plan.place(exit.node)) < 0.4 * self.spacing {
                self.driveway_to(exit.node, last);
            }
        }
    }

    /// A service road between two nodes, perhaps with a bend and a gate.
    fn driveway_to(&mut self, from: usize, to: usize) {
        let (a, b) = (self.plan.place(from), self.plan.place(to));
        let jitter = [self.dice.between(-1.0, 1.0), self.dice.between(-1.0, 1.0)];
        let middle = plus(between(a, b, self.dice.between(0.3, 0.7)), jitter, 1.0);
        let tags = self.dice.pick(&["highway=service", "highway=service", "highway=service access=private"]);
        let way = self.plan.path(from, &[middle], Some(to), tags);
        let gate = self.dice.pick(&["", "", "barrier=lift_gate", "barrier=gate access=private"]);
        self.plan.nodes[self.plan.ways[way].nodes[1]].tags = gate.to_owned();
    }

    /// A road that leaves a street and comes back to it.
    fn service_loop(&mut self, x: usize, y: usize) {
        let Some(mouth) = self.any_mouth(x, y) else { return };
        let way = self.blocks[mouth.block].way;
        let start: f64 = (0..mouth.at)
            .map(|i| {
                let nodes = &self.plan.ways[way].nodes;
                distance(self.plan.place(nodes[i]), self.plan.place(nodes[i + 1]))
            })
            .sum();
        let wide = self.dice.between(12.0, 35.0);
        let back = self.plan.along(way, start + wide);
        let (from, back) = (mouth.node, self.plan.ways[way].nodes[back]);
        let (a, b) = (self.plan.place(from), self.plan.place(back));
        let deep = self.dice.between(7.0, 20.0);
        let parts: &[f64] = self.dice.pick(&[&[0.5][..], &[0.15, 0.85], &[0.2, 0.5, 0.8], &[-0.1, 0.4, 1.1]]);
        let bow: Vec<Place> = parts
            .iter()
            .map(|part| plus(between(a, b, *part), heading(mouth.inward), deep * self.dice.between(0.8, 1.2)))
            .collect();
        let tags = self.dice.pick(&["highway=service", "highway=service oneway=yes", "highway=residential"]);
        self.plan.path(from, &bow, Some(back), tags);
    }

    /// A street into a quarter that ends with a ring or a place to turn.
    fn lollipop(&mut self, x: usize, y: usize) {
        let Some(mouth) = self.any_mouth(x, y) else { return };
        let tags = self.dice.pick(&["highway=residential", "highway=service", "highway=living_street"]);
        let into = mouth.inward + self.dice.between(-0.6, 0.6);
        let neck = plus(self.plan.place(mouth.node), heading(into), self.dice.between(12.0, 0.3 * self.spacing));
        let neck = self.plan.node(neck, "");
        self.plan.way(vec![mouth.node, neck], tags);
        if self.dice.chance(0.3) {
            self.plan.nodes[neck].tags = "highway=turning_circle".to_owned();
            return;
        }
        let radius = self.dice.between(7.0, 14.0);
        let center = plus(self.plan.place(neck), heading(into), radius);
        let count = 5 + self.dice.below(6);
        let ring: Vec<Place> = (1..count)
            .map(|i| {
                plus(center, heading(into + PI + TAU * i as f64 / count as f64), radius * self.dice.between(0.9, 1.1))
            })
            .collect();
        let one_way = self.dice.pick(&["", "", " oneway=yes"]);
        self.plan.path(neck, &ring, Some(neck), &format!("{tags}{one_way}"));
    }

    /// A street across a quarter from crossing to crossing.
    fn diagonal(&mut self, x: usize, y: usize) {
        let corner = |right: usize, up: usize| self.crossings[(x + right) * self.side + y + up].plain;
        let ends = [[corner(0, 0), corner(1, 1)], [corner(1, 0), corner(0, 1)]];
        let Some([Some(a), Some(b)]) = ends.into_iter().find(|ends| ends.iter().all(Option::is_some)) else { return };
        let (from, to) = (self.plan.place(a), self.plan.place(b));
        let aside = heading(angle(from, to) + FRAC_PI_2);
        let off = self.dice.between(-0.2, 0.2) * self.spacing;
        let places = [0.3, 0.6].map(|part| plus(between(from, to, part), aside, off));
        let tags =
            self.dice.pick(&["highway=tertiary lanes=2", "highway=residential", "highway=residential oneway=yes"]);
        self.plan.path(a, &places, Some(b), tags);
    }

    /// A road that leaves a street at an acute angle and turns back.
    fn hairpin(&mut self, x: usize, y: usize) {
        let Some(mouth) = self.any_mouth(x, y) else { return };
        let bent = if (mouth.inward - mouth.along).sin() > 0.0 { 1.0 } else { -1.0 };
        let mut to = mouth.along + bent * self.dice.between(0.2, 0.9);
        let mut place = self.plan.place(mouth.node);
        let places: Vec<Place> = (0..2 + self.dice.below(3))
            .map(|_| {
                place = plus(place, heading(to), self.dice.between(8.0, 20.0));
                to += bent * self.dice.between(0.3, 1.9);
                place
            })
            .collect();
        let tags = self.dice.pick(&["highway=service", "highway=residential", "highway=tertiary oneway=yes"]);
        self.plan.path(mouth.node, &places, None, tags);
    }

    /// A narrow street from a side of a quarter to the opposite one.
    fn alley(&mut self, x: usize, y: usize) {
        let (side, parts) = (self.dice.below(2), [0, 1].map(|_| self.dice.between(0.25, 0.75)));
        let (Some(a), Some(b)) = (self.mouth((x, y), side, parts[0]), self.mouth((x, y), side + 2, parts[1])) else {
            return;
        };
        let (from, to) = (self.plan.place(a.node), self.plan.place(b.node));
        let mut jitter = || [self.dice.between(-6.0, 6.0), self.dice.between(-6.0, 6.0)];
        let places = [0.3, 0.5, 0.7].map(|part| plus(between(from, to, part), jitter(), 1.0));
        let tags = self.dice.pick(&[
            "highway=service service=alley",
            "highway=living_street oneway=yes",
            "highway=residential",
        ]);
        self.plan.path(a.node, &places, Some(b.node), tags);
    }

    fn driveway(&mut self, x: usize, y: usize) {
        let Some(mouth) = self.any_mouth(x, y) else { return };
        let into = heading(mouth.inward + self.dice.between(-1.0, 1.0));
        let from = self.plan.place(mouth.node);
        let far = self.dice.between(8.0, 22.0);
        let gate = self.dice.pick(&["", "", "barrier=gate access=private", "barrier=gate"]);
        let at_gate = self.plan.node(plus(from, into, far * self.dice.between(0.3, 0.6)), gate);
        let end = self.plan.node(plus(from, into, far), "");
        let access = self.dice.pick(&["", " access=private", " access=customers"]);
        self.plan.way(vec![mouth.node, at_gate, end], &format!("highway=service service=driveway{access}"));
    }

    /// A lane past a crossing for those who turn to the near side.
    fn slip_lane(&mut self, x: usize, y: usize) {
        let arriving = self.dice.below(4);
        let leaving = if self.left_hand { (arriving + 3) % 4 } else { (arriving + 1) % 4 };
        let ends = [arriving, leaving].map(|arm| {
            let other = if arm == arriving { leaving } else { arriving };
            self.arm((x, y), arm, if other == 0 || other == 1 { 1 } else { 0 })
        });
        let [Some((a, at_end_a)), Some((b, at_end_b))] = ends else { return };
        let mut on = |block: usize, at_end: bool, far: f64| {
            let way = self.blocks[block].way;
            let length = self.plan.length(way);
            if length < far + 25.0 {
                return None;
            }
            let at = self.plan.along(way, if at_end { length - far } else { far });
            Some(self.plan.ways[way].nodes[at])
        };
        let far = self.dice.between(14.0, 40.0);
        let (Some(from), Some(to)) = (on(a, at_end_a, far), on(b, at_end_b, far)) else { return };
        let center = self.crossings[x * self.side + y].center;
        let (f, t) = (self.plan.place(from), self.plan.place(to));
        let middle = between(between(f, t, 0.5), center, self.dice.between(0.1, 0.45));
        let bow = [between(f, middle, self.dice.between(0.4, 0.8)), middle, between(t, middle, 0.6)];
        let tags = [
            "highway=secondary_link oneway=yes",
            "highway=tertiary_link oneway=yes lanes=1",
            "highway=service oneway=yes",
        ];
        let tags = self.dice.pick(&tags);
        self.plan.path(from, &bow, Some(to), tags);
    }

    /// The block that is an arm of a crossing, the carriageway on this side of it, and whether it ends there.
    fn arm(&self, (x, y): (usize, usize), arm: usize, carriageway: usize) -> Option<(usize, bool)> {
        let key = |carriageway| match arm {
            0 => Some((false, y, x, carriageway)),
            1 => Some((true, x, y, carriageway)),
            2 => Some((false, y, x.checked_sub(1)?, carriageway)),
            _ => Some((true, x, y.checked_sub(1)?, carriageway)),
        };
        let block = self.block_of(key(carriageway)?).or_else(|| self.block_of(key(0)?))?;
        Some((block, arm > 1))
    }

    /// A road from a roundabout to a car park.
    fn arm_of_roundabout(&mut self, crossing: usize) {
        let (ring, center) = (self.crossings[crossing].ring.clone(), self.crossings[crossing].center);
        let from = self.dice.pick(&ring);
        let place = self.plan.place(from);
        let into = angle(center, place) + self.dice.between(-0.4, 0.4);
        let places = [10.0, 22.0].map(|far| plus(place, heading(into), far));
        let tags = self.dice.pick(&["highway=service", "highway=service oneway=yes", "highway=service access=private"]);
        self.plan.path(from, &places, None, tags);
    }

    fn bus_bay(&mut self, block: usize) {
        let way = self.blocks[block].way;
        let length = self.plan.length(way);
        if length < 60.0 {
            return;
        }
        let begin = self.plan.along(way, length * self.dice.between(0.2, 0.4));
        let Some(bay) = self.plan.split(way, begin) else { return };
        let end = self.plan.along(bay, self.dice.between(15.0, 25.0));
        self.plan.split(bay, end);
        self.plan.ways[bay].tags += self.dice.pick(&[" bus_bay=right", " bus_bay=both", " parking:left=lane"]);
    }

    fn crosswalk(&mut self, block: usize) {
        let way = self.blocks[block].way;
        let length = self.plan.length(way);
        let far = self.dice.between(5.0, 13.0);
        let at = self.plan.along(way, if self.dice.chance(0.5) { far } else { (length - far).max(0.0) });
        let node = self.plan.ways[way].nodes[at];
        let place = self.plan.place(node);
        let next = self.plan.ways[way].nodes[if at > 0 { at - 1 } else { 1 }];
        let across = heading(angle(place, self.plan.place(next)) + FRAC_PI_2);
        let tags = self.dice.pick(&["highway=crossing crossing=marked", "highway=crossing crossing=traffic_signals"]);
        if self.plan.nodes[node].tags.is_empty() {
            self.plan.nodes[node].tags = tags.to_owned();
        }
        let ends = [-9.0, 9.0].map(|far| self.plan.node(plus(place, across, far), ""));
        self.plan.way(vec![ends[0], node, ends[1]], "highway=footway footway=crossing");
    }

    /// A tram, or a place to cross, between two carriageways.
    fn between_carriageways(&mut self, block: usize) {
        let (north, at, along, carriageway) = self.blocks[block].key;
        let Some(other) = self.block_of((north, at, along, 1)).filter(|_| carriageway == 0) else { return };
        let ways = [block, other].map(|block| self.blocks[block].way);
        if self.dice.chance(0.5) {
            let [a, b] = [false, true].map(|last| {
                let end = |way: usize| {
                    let nodes = &self.plan.ways[way].nodes;
                    self.plan.place(nodes[if last { nodes.len() - 1 } else { 0 }])
                };
                between(end(ways[0]), end(ways[1]), 0.5)
            });
            let from = self.plan.node(a, "");
            self.plan.path(from, &[b], None, "railway=tram");
            return;
        }
        let part = self.dice.between(0.3, 0.7);
        let ends = ways.map(|way| {
            let at = self.plan.along(way, self.plan.length(way) * part);
            self.plan.ways[way].nodes[at]
        });
        let tags = self.dice.pick(&["highway=secondary_link", "highway=secondary_link oneway=yes", "highway=service"]);
        self.plan.way(ends.to_vec(), tags);
    }

    /// A carriageway of a motorway south of the town, with ramps from it and onto it.
    fn motorway(&mut self) {
        let (y, width) = (-self.dice.between(60.0, 100.0), self.spacing * (self.side - 1) as f64);
        // Beside the town one drives to the west, or on the left to the east.
        let onward = if self.left_hand { 1.0 } else { -1.0 };
        let middle = width / 2.0;
        let far = |along: f64| [middle + onward * along, y];
        let half = width / 2.0;
        let from = self.plan.node(far(-half - 150.0), "");
        let lanes = self.dice.pick(&["lanes=2", "lanes=3", "lanes=3 turn:lanes=through|through|through;slight_right"]);
        let bends = [-half - 40.0, -half, half, half + 40.0].map(far);
        let way = self.plan.path(
            from,
            &bends,
            Some(self.plan.nodes.len() + 4),
            &format!("highway=motorway oneway=yes {lanes}"),
        );
        let end = self.plan.node(far(half + 150.0), "");
        assert_eq!(self.plan.ways[way].nodes.last(), Some(&end));
        let off = self.plan.along(way, self.dice.between(40.0, 120.0));
        let off = self.plan.ways[way].nodes[off];
        let on = self.plan.along(way, self.plan.length(way) - self.dice.between(40.0, 120.0));
        let on = self.plan.ways[way].nodes[on];
        let [first, last] = if self.left_hand { [0, self.side - 1] } else { [self.side - 1, 0] };
        for (node, crossing, leaving) in [(off, first, true), (on, last, false)] {
            let arms = &self.crossings[crossing * self.side].arms[3];
            let Some(to) = arms.first().copied() else { continue };
            let (a, b) = (self.plan.place(node), self.plan.place(to));
            let side = if leaving { onward } else { -onward };
            let mut near = |along: f64, up: f64| plus(a, [side * along, up + self.dice.between(-0.5, 0.5)], 1.0);
            let mut places = vec![near(30.0, 3.5), near(60.0, 11.0)];
            places.push(plus(between(a, b, 0.6), [0.0, self.dice.between(-5.0, 5.0)], 1.0));
            let tags =
                self.dice.pick(&["highway=motorway_link oneway=yes", "highway=motorway_link oneway=yes lanes=2"]);
            let way = self.plan.path(node, &places, Some(to), tags);
            self.plan.ways[way].reversed = !leaving;
        }
    }
}
