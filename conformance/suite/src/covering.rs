//! Covering arrays: few rows in which the values of any three parameters occur in every combination.

use std::collections::BTreeSet;

/// Two earlier parameters, their values, and the value of the parameter that is added.
type Triple = [usize; 5];

/// The rows of a covering array of strength 3: the number of a value for each parameter, below its number of values in
/// `counts`. A parameter without values gives no rows.
///
/// The rows begin with all combinations of the first three parameters, so that the largest ones should come first; each
/// further parameter gets the values that cover the most, and rows of its own for what remains (the method IPOG).
pub(crate) fn rows(counts: &[usize]) -> Vec<Vec<usize>> {
    let (first, further) = counts.split_at(counts.len().min(3));
    let mut rows = vec![Vec::new()];
    for count in first {
        rows = rows.iter().flat_map(|row| (0..*count).map(|value| with(row, value))).collect();
    }
    for (parameter, count) in (first.len()..).zip(further) {
        extend(&mut rows, counts.get(..parameter).unwrap_or_default(), *count);
    }
    rows
}

fn with(row: &[usize], value: usize) -> Vec<usize> {
    [row, &[value]].concat()
}

/// Adds a parameter of `count` values to rows that cover the earlier parameters.
fn extend(rows: &mut Vec<Vec<usize>>, earlier: &[usize], count: usize) {
    let mut open = all_triples(earlier, count);
    for row in rows.iter_mut() {
        let most = |value: &usize| triples(row, *value).filter(|triple| open.contains(triple)).count();
        // Of equal values the first one counts.
        let Some(best) = (0..count).rev().max_by_key(most) else { return rows.clear() };
        triples(row, best).for_each(|triple| _ = open.remove(&triple));
        row.push(best);
    }
    while let Some([first, a, second, b, value]) = open.first().copied() {
        let mut row = vec![None; earlier.len()];
        for [i, x, j, y, z] in open.clone() {
            let fits = |at: usize, wanted: usize| row.get(at).is_some_and(|set| set.is_none_or(|set| set == wanted));
            if z == value && fits(i, x) && fits(j, y) || [i, x, j, y, z] == [first, a, second, b, value] {
                row[i] = Some(x);
                row[j] = Some(y);
            }
        }
        let row: Vec<usize> = row.into_iter().map(Option::unwrap_or_default).collect();
        triples(&row, value).for_each(|triple| _ = open.remove(&triple));
        rows.push(with(&row, value));
    }
}

/// All combinations of two earlier parameters with the added one.
fn all_triples(earlier: &[usize], count: usize) -> BTreeSet<Triple> {
    let mut all = BTreeSet::new();
    for (second, b) in earlier.iter().enumerate() {
        for (first, a) in earlier.iter().enumerate().take(second) {
            let values = (0..*a).flat_map(|x| (0..*b).map(move |y| (x, y)));
            all.extend(values.flat_map(|(x, y)| (0..count).map(move |z| [first, x, second, y, z])));
        }
    }
    all
}

/// The combinations of two values of a row with the value of the added parameter.
fn triples(row: &[usize], value: usize) -> impl Iterator<Item = Triple> {
    let pairs = row.iter().enumerate().flat_map(move |(second, b)| {
        row.iter().enumerate().take(second).map(move |(first, a)| [first, *a, second, *b])
    });
    pairs.map(move |[first, a, second, b]| [first, a, second, b, value])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::{prop_assert, proptest};

    #[test]
    fn two_values_of_four_parameters_need_eight_rows() {
        assert_eq!(rows(&[2, 2, 2, 2]).len(), 8);
        assert_eq!(rows(&[3, 2]), [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1]]);
        assert!(rows(&[3, 2, 0]).is_empty());
        assert!(rows(&[3, 2, 2, 0]).is_empty());
    }

    proptest! {
        #[test]
        fn every_combination_of_three_values_is_in_a_row(counts in vec(1_usize..5, 3..6)) {
            let rows = rows(&counts);
            prop_assert!(rows.len() <= counts.iter().product());
            for (third, count) in counts.iter().enumerate() {
                for [first, a, second, b, value] in all_triples(&counts[..third], *count) {
                    let is_in = |row: &Vec<usize>| row[first] == a && row[second] == b && row[third] == value;
                    prop_assert!(rows.iter().any(is_in), "{first} = {a}, {second} = {b}, {third} = {value}");
                }
            }
        }
    }
}
