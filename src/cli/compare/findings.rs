//! What the figures say, in words: what the curved surface gains over flat triangles, what it costs,
//! and where flat triangles are better.

use serde::Serialize;

use super::figures::{Figures, FormFigures};
use super::table::number;

/// One thing to know.
#[derive(Debug, Serialize)]
pub struct Finding {
    /// Whom it speaks for.
    pub favours: Favours,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Favours {
    Curved,
    Flat,
    Neither,
}

/// Values that are as near as this to each other are said to be about the same.
const ALIKE: f64 = 1.05;

/// All that the figures say.
pub fn of(figures: &Figures) -> Vec<Finding> {
    let mut findings = match figures.reference() {
        Some(_) => errors(figures.flat(), figures.curved()),
        None => differences(figures.curved()),
    };
    findings.extend(terminator(figures));
    findings.extend(left_flat(figures.curved()));
    findings.push(time(figures));
    findings.push(setup(figures.curved()));
    findings.push(memory(figures));
    findings.extend(
        figures
            .reference()
            .map(|fine| price_of_fineness(figures, fine)),
    );
    findings
}

/// How far either is from the reference.
fn errors(flat: &FormFigures, curved: &FormFigures) -> Vec<Finding> {
    let (Some(a), Some(b)) = (&flat.apart, &curved.apart) else {
        return Vec::new();
    };
    let mut findings = vec![
        nearer(
            "Picture, by root mean square",
            "of the whole scale",
            100.0 * b.rmse,
            100.0 * a.rmse,
            "%",
        ),
        nearer(
            "Picture, as the eye sees it (FLIP, 0 to 1)",
            "",
            b.flip,
            a.flip,
            "",
        ),
    ];
    let mut add = |what, note, curved: Option<f64>, flat: Option<f64>, unit| {
        if let (Some(curved), Some(flat)) = (curved, flat) {
            findings.push(nearer(what, note, curved, flat, unit));
        }
    };
    let mean = |spread: Option<curvetri::compare::Spread>| spread.map(|spread| spread.mean);
    add(
        "Outline",
        "on average",
        mean(b.outline),
        mean(a.outline),
        "pixels",
    );
    add(
        "Normals for shading",
        "on average",
        mean(b.shading_normal),
        mean(a.shading_normal),
        "degrees",
    );
    add(
        "Normals of the geometry itself",
        "on average",
        mean(b.geometric_normal),
        mean(a.geometric_normal),
        "degrees",
    );
    findings
}

/// Which of two errors is the smaller, and how much.
fn nearer(what: &str, note: &str, curved: f64, flat: f64, unit: &str) -> Finding {
    let [c, f] = [curved, flat].map(number);
    let unit = [unit, note]
        .iter()
        .filter(|w| !w.is_empty())
        .fold(String::new(), |all, w| all + " " + w);
    let gap = |near: f64, far: f64| {
        if near > 0.0 {
            format!("{} times as near", number(far / near))
        } else {
            "exact".to_owned()
        }
    };
    let (favours, verdict) = if flat > ALIKE * curved {
        (
            Favours::Curved,
            format!("the curved surface is {}", gap(curved, flat)),
        )
    } else if curved > ALIKE * flat {
        (
            Favours::Flat,
            format!("flat triangles are {}", gap(flat, curved)),
        )
    } else {
        (Favours::Neither, "about the same".to_owned())
    };
    Finding {
        favours,
        text: format!(
            "{what}: the curved surface is {c} off the reference, flat triangles {f}{unit}: {verdict}."
        ),
    }
}

/// How far they are from each other, where nothing says which is right.
fn differences(curved: &FormFigures) -> Vec<Finding> {
    let Some(apart) = &curved.apart else {
        return Vec::new();
    };
    let mut text = format!(
        "The pictures differ by {} % (root mean square), as the eye sees it by {} (FLIP, 0 to 1)",
        number(100.0 * apart.rmse),
        number(apart.flip)
    );
    if let Some(outline) = apart.outline {
        text += &format!(
            ", the outlines by {} pixels on average and {} at the most",
            number(outline.mean),
            number(outline.max)
        );
    }
    text += ". Which is nearer to the true surface only a finer mesh of the same body can tell: --reference.";
    vec![Finding {
        favours: Favours::Neither,
        text,
    }]
}

fn terminator(figures: &Figures) -> Option<Finding> {
    let [flat, curved] = [figures.flat(), figures.curved()].map(|form| form.darkened);
    if flat.lit == 0 {
        return None;
    }
    let [f, c] = [flat, curved].map(|darkened| number(100.0 * darkened.share()));
    let truth = match figures.reference() {
        Some(_) => format!("; the curved surface {c} %"),
        None => " on the curved surface".to_owned(),
    };
    let favours = match flat.darkened.cmp(&curved.darkened) {
        std::cmp::Ordering::Greater => Favours::Curved,
        std::cmp::Ordering::Less => Favours::Flat,
        std::cmp::Ordering::Equal => Favours::Neither,
    };
    Some(Finding {
        favours,
        text: format!(
            "Shadow terminator: flat triangles darken {f} % of the pixels where the sun shines{truth}."
        ),
    })
}

/// Triangles that the method leaves flat.
fn left_flat(curved: &FormFigures) -> Option<Finding> {
    let kept = ["flat_sliver", "flat_back_normal", "flat_bend", "flat_fold"];
    let kept: usize = kept.iter().map(|kind| curved.count(kind)).sum();
    let total = curved.count("total");
    (kept > 0).then(|| Finding {
        favours: Favours::Flat,
        text: format!(
            "{kept} of {total} triangles stay flat in the curved surface, because they are too thin, or bend too much for the method."
        ),
    })
}

fn time(figures: &Figures) -> Finding {
    let (flat, curved) = (figures.flat(), figures.curved());
    let over = &curved.over_flat;
    let runs = figures.picture.runs;
    let runs = if runs > 1 {
        format!(
            "; {} to {} times over {runs} runs",
            number(over.render_least),
            number(over.render_most)
        )
    } else {
        String::new()
    };
    Finding {
        favours: cheaper(over.render),
        text: format!(
            "Rendering the curved surface takes {} times as long as flat triangles ({} s against {} s{runs}).",
            number(over.render),
            number(curved.seconds.render),
            number(flat.seconds.render)
        ),
    }
}

fn setup(curved: &FormFigures) -> Finding {
    Finding {
        favours: cheaper(curved.over_flat.build),
        text: format!(
            "Setting it up (preparing the patches and building the tree) takes {} times as long: {} s.",
            number(curved.over_flat.build),
            number(curved.seconds.curve + curved.seconds.build)
        ),
    }
}

fn memory(figures: &Figures) -> Finding {
    let (flat, curved) = (figures.flat(), figures.curved());
    Finding {
        favours: cheaper(curved.over_flat.bytes),
        text: format!(
            "It takes {} times the memory: {} MB against {} MB.",
            number(curved.over_flat.bytes),
            number(curved.bytes.total as f64 * 1e-6),
            number(flat.bytes.total as f64 * 1e-6)
        ),
    }
}

/// Flat triangles can be good as well, if there are enough of them.
fn price_of_fineness(figures: &Figures, fine: &FormFigures) -> Finding {
    let curved = figures.curved();
    let ratio = |fine: f64, curved: f64| number(fine / curved);
    Finding {
        favours: Favours::Neither,
        text: format!(
            "The other way to a round look is more flat triangles: the reference has {} times as many, \
             and takes {} times the memory of the curved surface and {} times its time to render.",
            ratio(fine.count("total") as f64, curved.count("total") as f64),
            ratio(fine.bytes.total as f64, curved.bytes.total as f64),
            ratio(fine.seconds.render, curved.seconds.render)
        ),
    }
}

fn cheaper(over_flat: f64) -> Favours {
    if over_flat > ALIKE {
        Favours::Flat
    } else if over_flat * ALIKE < 1.0 {
        Favours::Curved
    } else {
        Favours::Neither
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_is_nearer_is_said_to_be() {
        let of = |curved, flat| nearer("Outline", "on average", curved, flat, "pixels");
        let gain = of(0.1, 1.5);
        assert_eq!(gain.favours, Favours::Curved);
        assert_eq!(
            gain.text,
            "Outline: the curved surface is 0.1 off the reference, flat triangles 1.5 pixels on \
             average: the curved surface is 15 times as near."
        );
        let loss = of(0.4, 0.2);
        assert_eq!(loss.favours, Favours::Flat);
        assert!(
            loss.text.ends_with("flat triangles are 2 times as near."),
            "{}",
            loss.text
        );
        assert_eq!(of(0.2, 0.201).favours, Favours::Neither);
        assert_eq!(of(0.0, 0.0).favours, Favours::Neither);
        assert!(of(0.0, 0.3).text.ends_with("the curved surface is exact."));
    }

    #[test]
    fn what_costs_less_is_favoured() {
        assert_eq!(
            [3.0, 1.01, 0.5].map(cheaper),
            [Favours::Flat, Favours::Neither, Favours::Curved]
        );
    }
}
