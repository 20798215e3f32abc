//! Layered layout (Sugiyama, Tagawa, Toda 1981): boxes stand on given layers, nets run downward from
//! one port to ports on lower layers. A net that passes a layer gets a lane there, one for all its
//! ends, so that no wire runs behind a box. Order within layers by barycentres; coordinates by least
//! squares under the order, which pooling adjacent violators solves exactly.

/// Room between boxes of a layer.
const GAP: f64 = 18.0;
/// Width of a lane.
const LANE: f64 = 10.0;
/// Rounds of down and up sweeps that look for an order with few crossings.
const ROUNDS: usize = 16;

/// A box.
pub struct Item {
    /// Its layer, 0 at the top.
    pub layer: usize,
    /// Its least width; it is as wide as its ports ask for.
    pub width: f64,
    /// The widths of the ports on its upper side.
    pub inputs: Vec<f64>,
    /// The widths of the ports on its lower side.
    pub outputs: Vec<f64>,
}

/// From an output of an item to inputs of items on lower layers.
pub struct Net {
    /// The item and its output, by position.
    pub from: (usize, usize),
    /// Items and their inputs, by position.
    pub to: Vec<(usize, usize)>,
}

/// Where everything stands. Layers have no heights here.
pub struct Layout {
    /// Left and width of each item.
    pub items: Vec<(f64, f64)>,
    /// Centres of the inputs of each item.
    pub inputs: Vec<Vec<f64>>,
    /// Centres of the outputs of each item.
    pub outputs: Vec<Vec<f64>>,
    /// The way of each net.
    pub nets: Vec<Route>,
    /// Right end of all.
    pub width: f64,
}

/// How a net runs.
#[derive(Default)]
pub struct Route {
    /// From the bottom of a layer to the top of the next: the upper layer, start, end.
    pub wires: Vec<(usize, f64, f64)>,
    /// Layers that the net passes, and where.
    pub lanes: Vec<(usize, f64)>,
}

/// A box or a lane.
struct Cell {
    layer: usize,
    width: f64,
    /// Ports above and below: widths, and the order in which they stand.
    ports: [Vec<f64>; 2],
    order: [Vec<usize>; 2],
    lane: bool,
    /// Links above and below, by index.
    links: [Vec<usize>; 2],
}

/// A piece of a net from a cell to one on the next layer.
struct Link {
    net: usize,
    /// The upper and the lower cell, and their ports.
    cells: [usize; 2],
    ports: [usize; 2],
}

const UP: usize = 0;
const DOWN: usize = 1;

struct Work {
    cells: Vec<Cell>,
    links: Vec<Link>,
    /// Cells of each layer, left to right.
    rows: Vec<Vec<usize>>,
    /// Left end of each cell.
    left: Vec<f64>,
}

/// Places boxes and wires. Layers may as well be columns: widths are then heights.
///
/// ```
/// use framegraph::layered::{Item, Net, layout};
///
/// let boxed = |layer, inputs, outputs| Item {
///     layer,
///     width: 60.0,
///     inputs: vec![20.0; inputs],
///     outputs: vec![20.0; outputs],
/// };
/// let net = Net { from: (0, 0), to: vec![(1, 0)] };
/// let placed = layout(vec![boxed(0, 0, 1), boxed(1, 1, 0)], &[net]);
/// // One wire from layer 0 to the next, straight down.
/// let (layer, from, to) = placed.nets[0].wires[0];
/// assert_eq!(layer, 0);
/// assert!((from - to).abs() < 0.01);
/// ```
pub fn layout(items: Vec<Item>, nets: &[Net]) -> Layout {
    let count = items.len();
    let mut work = Work::new(items, nets);
    work.arrange();
    let start = work.left.iter().copied().fold(f64::INFINITY, f64::min);
    let start = if start.is_finite() { start } else { 0.0 };
    for left in &mut work.left {
        *left -= start;
    }
    let mut routes: Vec<Route> = nets.iter().map(|_| Route::default()).collect();
    for link in &work.links {
        let [from, to] = [UP, DOWN].map(|end| work.port(link.cells[end], 1 - end, link.ports[end]));
        let upper = link.cells[UP];
        routes[link.net]
            .wires
            .push((work.cells[upper].layer, from, to));
        if work.cells[upper].lane {
            let lane = (work.cells[upper].layer, from);
            if !routes[link.net].lanes.contains(&lane) {
                routes[link.net].lanes.push(lane);
            }
        }
    }
    let ports = |side: usize| {
        let of = |c: usize| {
            (0..work.cells[c].ports[side].len())
                .map(|p| work.port(c, side, p))
                .collect()
        };
        (0..count).map(of).collect()
    };
    let ends = work
        .left
        .iter()
        .zip(&work.cells)
        .map(|(left, cell)| left + cell.width);
    Layout {
        items: (0..count)
            .map(|c| (work.left[c], work.cells[c].width))
            .collect(),
        inputs: ports(UP),
        outputs: ports(DOWN),
        nets: routes,
        width: ends.fold(0.0, f64::max),
    }
}

impl Work {
    fn new(items: Vec<Item>, nets: &[Net]) -> Work {
        let mut cells: Vec<Cell> = items
            .into_iter()
            .map(|item| {
                let least = item
                    .inputs
                    .iter()
                    .sum::<f64>()
                    .max(item.outputs.iter().sum());
                Cell {
                    layer: item.layer,
                    width: item.width.max(least),
                    order: [
                        (0..item.inputs.len()).collect(),
                        (0..item.outputs.len()).collect(),
                    ],
                    ports: [item.inputs, item.outputs],
                    lane: false,
                    links: Default::default(),
                }
            })
            .collect();
        let mut links: Vec<Link> = Vec::new();
        for (n, net) in nets.iter().enumerate() {
            let (source, output) = net.from;
            let top = cells[source].layer;
            let bottom = net.to.iter().map(|t| cells[t.0].layer).max().unwrap_or(top);
            // The cell that the net comes from on each layer.
            let mut above = vec![(source, output)];
            for layer in top + 1..bottom {
                cells.push(Cell {
                    layer,
                    width: LANE,
                    ports: [vec![LANE], vec![LANE]],
                    order: [vec![0], vec![0]],
                    lane: true,
                    links: Default::default(),
                });
                above.push((cells.len() - 1, 0));
            }
            let lanes = above.windows(2).map(|w| (w[0], w[1])).collect::<Vec<_>>();
            let ends = net.to.iter().filter(|t| cells[t.0].layer > top);
            let ends = ends.map(|&t| (above[cells[t.0].layer - 1 - top], t));
            for (upper, lower) in lanes.into_iter().chain(ends.collect::<Vec<_>>()) {
                for (end, cell) in [upper.0, lower.0].into_iter().enumerate() {
                    cells[cell].links[1 - end].push(links.len());
                }
                links.push(Link {
                    net: n,
                    cells: [upper.0, lower.0],
                    ports: [upper.1, lower.1],
                });
            }
        }
        let layers = cells.iter().map(|c| c.layer + 1).max().unwrap_or(0);
        let mut rows = vec![Vec::new(); layers];
        for (c, cell) in cells.iter().enumerate() {
            rows[cell.layer].push(c);
        }
        let left = vec![0.0; cells.len()];
        Work {
            cells,
            links,
            rows,
            left,
        }
    }

    /// The centre of a port.
    fn port(&self, cell: usize, side: usize, port: usize) -> f64 {
        self.left[cell] + self.offset(cell, side, port)
    }

    /// The centre of a port from the left end of its cell; ports stand in the middle of their side.
    fn offset(&self, cell: usize, side: usize, port: usize) -> f64 {
        let c = &self.cells[cell];
        let widths = &c.ports[side];
        let before = c.order[side].iter().take_while(|&&p| p != port);
        (c.width - widths.iter().sum::<f64>()) / 2.0
            + before.map(|&p| widths[p]).sum::<f64>()
            + widths[port] / 2.0
    }

    fn arrange(&mut self) {
        for layer in 0..self.rows.len() {
            let row = self.rows[layer].clone();
            let middles = vec![(0.0, 1.0); row.len()];
            self.place(&row, &middles);
        }
        let mut best = (self.cost(), self.state());
        for round in 0..ROUNDS {
            let first = round % 2;
            self.sweep(first);
            self.sweep(1 - first);
            for _ in 0..2 {
                self.straighten();
            }
            let cost = self.cost();
            if cost < best.0 {
                best = (cost, self.state());
            }
        }
        (self.rows, self.left) = (best.1.0, best.1.1);
        for (cell, order) in self.cells.iter_mut().zip(best.1.2) {
            cell.order = order;
        }
        for _ in 0..ROUNDS {
            self.straighten();
        }
    }

    #[allow(clippy::type_complexity)]
    fn state(&self) -> (Vec<Vec<usize>>, Vec<f64>, Vec<[Vec<usize>; 2]>) {
        let orders = self.cells.iter().map(|c| c.order.clone());
        (self.rows.clone(), self.left.clone(), orders.collect())
    }

    /// Layer by layer, away from `side`: cells and their ports take the order of what they are linked to
    /// on that side.
    fn sweep(&mut self, side: usize) {
        let count = self.rows.len();
        for i in 0..count {
            let layer = if side == UP { i } else { count - 1 - i };
            let row = std::mem::take(&mut self.rows[layer]);
            let mut wished = Vec::with_capacity(row.len());
            for c in row {
                self.sort_ports(c, side);
                wished.push((c, self.wish(c, &[side])));
            }
            wished.sort_by(|a, b| {
                let middle =
                    |(c, (left, _)): &(usize, (f64, f64))| left + self.cells[*c].width / 2.0;
                middle(a).total_cmp(&middle(b))
            });
            let (row, wishes): (Vec<_>, Vec<_>) = wished.into_iter().unzip();
            self.place(&row, &wishes);
            self.rows[layer] = row;
        }
    }

    /// Keeps the order and pulls every wire straight.
    fn straighten(&mut self) {
        for i in (0..self.rows.len()).chain((0..self.rows.len()).rev()) {
            let row = self.rows[i].clone();
            let wishes: Vec<_> = row.iter().map(|&c| self.wish(c, &[UP, DOWN])).collect();
            self.place(&row, &wishes);
        }
    }

    /// Ports stand in the order of what they are linked to.
    fn sort_ports(&mut self, cell: usize, side: usize) {
        let count = self.cells[cell].ports[side].len();
        let mut sums = vec![(0.0, 0.0); count];
        for &l in &self.cells[cell].links[side] {
            let link = &self.links[l];
            let sum = &mut sums[link.ports[1 - side]];
            sum.0 += self.port(link.cells[side], 1 - side, link.ports[side]);
            sum.1 += 1.0;
        }
        // Ports without links stay where they are, after the others of the same middle.
        let middle = |p: &usize| match sums[*p] {
            (_, 0.0) => f64::INFINITY,
            (sum, n) => sum / n,
        };
        self.cells[cell].order[side].sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    }

    /// The left end that a cell's links want, and how much.
    fn wish(&self, cell: usize, sides: &[usize]) -> (f64, f64) {
        let (mut sum, mut weight) = (0.0, 0.0);
        for &side in sides {
            for &l in &self.cells[cell].links[side] {
                let link = &self.links[l];
                let (other, port) = (link.cells[side], link.ports[side]);
                let w = match (self.cells[cell].lane, self.cells[other].lane) {
                    (true, true) => 8.0,
                    (false, false) => 1.0,
                    _ => 2.0,
                };
                let at = self.port(other, 1 - side, port)
                    - self.offset(cell, side, link.ports[1 - side]);
                sum += w * at;
                weight += w;
            }
        }
        match weight > 0.0 {
            true => (sum / weight, weight),
            // Stays, when others let it.
            false => (self.left[cell], 0.05),
        }
    }

    /// Puts a row in its order as near to the wishes as room allows: the least sum of weighted squares.
    fn place(&mut self, row: &[usize], wishes: &[(f64, f64)]) {
        // Blocks of cells that touch: wished start, weight, number of cells.
        let mut blocks: Vec<(f64, f64, usize)> = Vec::new();
        let mut starts = Vec::with_capacity(row.len());
        let mut at = 0.0;
        for (i, &c) in row.iter().enumerate() {
            starts.push(at);
            let gap = match row.get(i + 1) {
                Some(&next) if self.cells[c].lane && self.cells[next].lane => 0.0,
                _ => GAP,
            };
            at += self.cells[c].width + gap;
        }
        for (&(wish, weight), start) in wishes.iter().zip(&starts) {
            blocks.push((wish - start, weight, 1));
            while let [.., a, b] = blocks[..] {
                if a.0 <= b.0 {
                    break;
                }
                blocks.truncate(blocks.len() - 2);
                let weight = a.1 + b.1;
                blocks.push(((a.0 * a.1 + b.0 * b.1) / weight, weight, a.2 + b.2));
            }
        }
        let mut cells = row.iter().zip(&starts);
        for (shift, _, count) in blocks {
            for (&c, start) in cells.by_ref().take(count) {
                self.left[c] = start + shift;
            }
        }
    }

    /// Crossings first, then the way that wires go sideways.
    fn cost(&self) -> (usize, f64) {
        let mut spans: Vec<Vec<(f64, f64)>> = vec![Vec::new(); self.rows.len()];
        let mut way = 0.0;
        for link in &self.links {
            let [a, b] = [UP, DOWN].map(|end| self.port(link.cells[end], 1 - end, link.ports[end]));
            spans[self.cells[link.cells[UP]].layer].push((a, b));
            way += (a - b).abs();
        }
        (spans.into_iter().map(crossings).sum(), way)
    }
}

/// How many pairs of lines cross: inversions of the lower ends, counted while sorting by merging.
fn crossings(mut lines: Vec<(f64, f64)>) -> usize {
    lines.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut ends: Vec<f64> = lines.into_iter().map(|l| l.1).collect();
    inversions(&mut ends)
}

fn inversions(values: &mut [f64]) -> usize {
    let middle = values.len() / 2;
    if middle == 0 {
        return 0;
    }
    let (left, right) = values.split_at_mut(middle);
    let mut count = inversions(left) + inversions(right);
    let mut merged = Vec::with_capacity(left.len() + right.len());
    let mut rest = left.iter().peekable();
    for r in right.iter() {
        while let Some(l) = rest.next_if(|l| *l <= r) {
            merged.push(*l);
        }
        count += rest.len();
        merged.push(*r);
    }
    merged.extend(rest);
    values.copy_from_slice(&merged);
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(layer: usize, inputs: usize, outputs: usize) -> Item {
        Item {
            layer,
            width: 40.0,
            inputs: vec![20.0; inputs],
            outputs: vec![20.0; outputs],
        }
    }

    /// ```text
    /// 0 -> 3      with 0, 1 above and 2, 3 below: crossed as declared, and straight when arranged
    /// 1 -> 2
    /// ```
    #[test]
    fn crossings_are_undone() {
        let items = vec![item(0, 0, 1), item(0, 0, 1), item(1, 1, 0), item(1, 1, 0)];
        let net = |from, to| Net {
            from: (from, 0),
            to: vec![(to, 0)],
        };
        let layout = layout(items, &[net(0, 3), net(1, 2)]);
        for route in &layout.nets {
            let (_, from, to) = route.wires[0];
            // A hundredth of a pixel is not seen.
            assert!((from - to).abs() < 0.01, "{from} {to}");
        }
    }

    /// A net over three layers has one lane, however many ends it has; boxes and lanes never overlap.
    #[test]
    fn a_net_has_one_lane_per_layer() {
        let items = vec![item(0, 0, 1), item(1, 1, 1), item(2, 2, 0), item(2, 1, 0)];
        let nets = [
            Net {
                from: (0, 0),
                to: vec![(1, 0), (2, 0), (3, 0)],
            },
            Net {
                from: (1, 0),
                to: vec![(2, 1)],
            },
        ];
        let layout = layout(items, &nets);
        let [lane] = layout.nets[0].lanes[..] else {
            panic!("{:?}", layout.nets[0].lanes)
        };
        let (left, width) = layout.items[1];
        assert_eq!(lane.0, 1);
        assert!(
            lane.1 < left || lane.1 > left + width,
            "the lane runs behind the box"
        );
        let [(a, w), (b, v)] = [layout.items[2], layout.items[3]];
        assert!(a + w + GAP <= b + 0.01 || b + v + GAP <= a + 0.01);
    }

    #[test]
    fn inversions_are_counted() {
        assert_eq!(inversions(&mut [1.0, 2.0, 3.0]), 0);
        assert_eq!(inversions(&mut [3.0, 2.0, 1.0]), 3);
        assert_eq!(inversions(&mut [2.0, 1.0, 4.0, 3.0, 2.0]), 4);
    }
}
