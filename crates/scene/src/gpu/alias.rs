//! Alias tables: choosing one of n in constant time.
//!
//! Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given Distribution".

/// One entry: take `index i` with probability `keep`, else `alias`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AliasEntry {
    pub keep: f32,
    pub alias: u32,
    /// Probability of i in all.
    pub probability: f32,
}

/// The table of these weights, none negative; all zero gives all probabilities 0.
pub(crate) fn alias_table(weights: &[f64]) -> Vec<AliasEntry> {
    let total: f64 = weights.iter().sum();
    let n = weights.len() as f64;
    let mut table: Vec<AliasEntry> = weights
        .iter()
        .enumerate()
        .map(|(i, w)| AliasEntry {
            keep: 1.0,
            alias: i as u32,
            probability: if total > 0.0 { (w / total) as f32 } else { 0.0 },
        })
        .collect();
    if total <= 0.0 {
        return table;
    }
    let mut share: Vec<f64> = weights.iter().map(|w| w / total * n).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..share.len()).partition(|&i| share[i] < 1.0);
    while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
        table[s].keep = share[s] as f32;
        table[s].alias = l as u32;
        share[l] -= 1.0 - share[s];
        if share[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // What rounding leaves over in `small` keeps itself; but nothing of weight 0 may.
    let heaviest = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
    for i in small {
        if weights[i] == 0.0 {
            table[i].keep = 0.0;
            table[i].alias = heaviest.unwrap_or(i) as u32;
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alias_table_has_the_probabilities_of_its_weights() {
        let weights = [0.0, 1.0, 5.0, 0.25, 0.0, 3.75, 1e-6];
        let table = alias_table(&weights);
        let total: f64 = weights.iter().sum();
        for (i, w) in weights.iter().enumerate() {
            let own = f64::from(table[i].keep);
            let from_others: f64 = table
                .iter()
                .filter(|e| e.alias == i as u32)
                .map(|e| 1.0 - f64::from(e.keep))
                .sum();
            let p = (own + from_others) / weights.len() as f64;
            // `keep` is stored as f32: each of the n entries errs by at most 2^-24 / n.
            assert!((p - w / total).abs() < 1e-7, "{i}: {p} {}", w / total);
            assert!((f64::from(table[i].probability) - w / total).abs() < 1e-7);
        }
    }

    #[test]
    fn no_weight_gives_no_probability() {
        assert!(alias_table(&[]).is_empty());
        assert!(alias_table(&[0.0; 3]).iter().all(|e| e.probability == 0.0));
    }
}
