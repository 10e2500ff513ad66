//! Stretches of a line inside a solid, and their combination by booleans.

/// Length up to which gaps and stretches vanish, mm.
///
/// Rounding separates faces that touch by about 1e-13 mm; nothing that a lab makes is a tenth of a picometre thick.
/// Dropping both keeps unions of touching solids whole and differences of solids with a common face free of slivers.
pub(crate) const SLIVER_MM: f64 = 1e-10;

/// Crossing of a line with a primitive's face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Position along the unit direction, mm.
    pub(crate) t_mm: f64,
    pub(crate) leaf: u32,
    pub(crate) face: u32,
}

/// Stretch of a line inside a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub(crate) enter: Hit,
    pub(crate) exit: Hit,
}

impl Span {
    fn is_sliver(&self) -> bool {
        self.exit.t_mm - self.enter.t_mm <= SLIVER_MM
    }
}

/// Pushes the stretch unless it is a sliver.
fn push(spans: &mut Vec<Span>, enter: Hit, exit: Hit) {
    let span = Span { enter, exit };
    if !span.is_sliver() {
        spans.push(span);
    }
}

/// Replaces `spans[from..]`, the concatenated lists of several solids, by their union.
pub(crate) fn unite(spans: &mut Vec<Span>, from: usize) {
    let tail = &mut spans[from..];
    // Leaf and face serve only to make the order of coincident faces deterministic.
    tail.sort_unstable_by(|a, b| {
        let key = |s: &Span| (s.enter.leaf, s.enter.face);
        a.enter.t_mm.total_cmp(&b.enter.t_mm).then_with(|| key(a).cmp(&key(b)))
    });
    let mut last = 0;
    for i in 1..tail.len() {
        let next = tail[i];
        if next.enter.t_mm <= tail[last].exit.t_mm + SLIVER_MM {
            if next.exit.t_mm > tail[last].exit.t_mm {
                tail[last].exit = next.exit;
            }
        } else {
            last += 1;
            tail[last] = next;
        }
    }
    // The minimum covers an empty list.
    let kept = from + (last + 1).min(tail.len());
    spans.truncate(kept);
}

/// Replaces `spans[from..middle]` and `spans[middle..]` by their intersection.
pub(crate) fn intersect(spans: &mut Vec<Span>, from: usize, middle: usize) {
    let end = spans.len();
    let (mut i, mut j) = (from, middle);
    while i < middle && j < end {
        let (a, b) = (spans[i], spans[j]);
        let enter = if a.enter.t_mm >= b.enter.t_mm { a.enter } else { b.enter };
        let a_ends_first = a.exit.t_mm <= b.exit.t_mm;
        push(spans, enter, if a_ends_first { a.exit } else { b.exit });
        if a_ends_first {
            i += 1;
        } else {
            j += 1;
        }
    }
    keep_from(spans, from, end);
}

/// Replaces `spans[from..middle]` and `spans[middle..]` by the difference, first minus second.
pub(crate) fn subtract(spans: &mut Vec<Span>, from: usize, middle: usize) {
    let end = spans.len();
    let mut j = middle;
    for i in from..middle {
        let whole = spans[i];
        let mut start = whole.enter;
        // Tools that end before this stretch end before all later ones, too.
        while j < end && spans[j].exit.t_mm <= start.t_mm {
            j += 1;
        }
        let mut k = j;
        while k < end && spans[k].enter.t_mm < whole.exit.t_mm {
            let tool = spans[k];
            push(spans, start, tool.enter);
            start = tool.exit;
            k += 1;
        }
        push(spans, start, whole.exit);
    }
    keep_from(spans, from, end);
}

/// Moves the result, `spans[end..]`, down to `from`.
fn keep_from(spans: &mut Vec<Span>, from: usize, end: usize) {
    let count = spans.len() - end;
    spans.copy_within(end.., from);
    spans.truncate(from + count);
}
