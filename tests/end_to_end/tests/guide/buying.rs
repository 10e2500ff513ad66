//! Whatever is bought says how it is ordered, and a lab's own words go before fabkit's.

use std::collections::BTreeSet;
use std::fs;

use fabkit_application::guides;
use fabkit_application::source::CheckErrors;
use fabkit_designs::{Design, builtin_yaml};
use fabkit_tests::{build_design, builtin_designs, command, fabkit, sample_bodies};
use serde_json::Value;

/// Keys of an order that are texts.
const TEXTS: [&str; 9] = [
    "article",
    "size",
    "maker",
    "number",
    "standard",
    "pack",
    "substitutes",
    "source",
    "price_source",
];

/// Every fixture that there is, of a dome and of a pad: those of other sensors are bought by the same articles.
fn fixtures() -> Vec<Design> {
    let of_sensor = |name: &str| {
        let yaml = builtin_yaml(name).expect("named by the registry");
        let project = fabkit_fixtures::load(name, yaml, &[]).unwrap();
        let names = project.fixture_names().into_iter();
        names.map(|fixture| project.fixture(fixture).unwrap()).collect::<Vec<_>>()
    };
    ["rtac0", "9dtact"].into_iter().flat_map(of_sensor).collect()
}

/// Name of each line, and what to order.
fn orders(guide: &Value) -> Vec<(&str, &Value)> {
    let lists = ["bought", "liquids", "stock", "supplies"].map(|list| &guide[list]);
    let lines = lists.into_iter().flat_map(|list| list.as_array().unwrap());
    lines.map(|line| (line["name"].as_str().unwrap(), &line["order"])).collect()
}

/// `ISO 7045`, `DIN 963`, `IEC 60115-8`.
fn is_standard(text: &str) -> bool {
    ["ISO", "DIN", "EN", "IEC", "AS", "JIS"].iter().any(|body| {
        let rest = text.strip_prefix(body).map(|rest| rest.strip_prefix(' ').unwrap_or(rest));
        rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    })
}

#[test]
fn every_piece_liquid_stock_and_supply_can_be_ordered() {
    let mut articles = BTreeSet::new();
    for mut design in builtin_designs().into_iter().chain(fixtures()) {
        design.sensor.bodies = sample_bodies(&design).cloned().collect();
        let stages = guides::find_stages(&design).unwrap();
        let guide = guides::collect_facts(&design, &stages, None, 3, &CheckErrors::default())
            .unwrap()
            .to_json();
        let name = &design.sensor.name;
        let mut sum_eur = 0.0;
        for (thing, order) in orders(&guide) {
            let at = format!("{name}: {thing}: {order}");
            for key in TEXTS {
                assert!(!order[key].as_str().unwrap().trim().is_empty(), "{at}");
            }
            let (is_there, standard) = (order["pack"] == "at hand", order["standard"].as_str());
            assert_eq!(order["price_eur"].as_f64().unwrap() > 0.0, !is_there, "{at}");
            let is_with_kit = order["kit"].is_string() && order["cost_eur"] == 0.0;
            assert_eq!(order["packs"] != 0, !is_there && !is_with_kit, "{at}");
            assert!(standard.is_some_and(|text| text == "none" || is_standard(text)), "{at}");
            // Where there is no number to order by, what matters is said.
            let is_said = !order["figures"].as_array().unwrap().is_empty();
            assert!(is_there || is_said || order["number"] != "any", "{at}");
            articles.insert(order["article"].as_str().unwrap().to_owned());
            let supplies = guide["supplies"].as_array().unwrap();
            if !supplies.iter().any(|one| one["name"] == *thing && one["used"] == "tool") {
                sum_eur += order["cost_eur"].as_f64().unwrap();
            }
        }
        assert!((guide["costs"]["total_eur"].as_f64().unwrap() - sum_eur).abs() < 1e-6, "{name}");
        assert_eq!(guide["costs"]["unknown"].as_array().unwrap().len(), 0, "{name}");
    }
    assert!(articles.len() > 60, "{articles:?}");
}

#[test]
fn packs_hold_what_is_needed_and_kits_are_paid_once() {
    let design = build_design("rtac0", &[]);
    let stages = guides::find_stages(&design).unwrap();
    let of = |units| {
        guides::collect_facts(&design, &stages, None, units, &CheckErrors::default())
            .unwrap()
            .to_json()
    };
    let [one, many] = [1, 40].map(of);
    let line = |guide: &Value, list: &str, name: &str| {
        let lines = guide[list].as_array().unwrap();
        lines.iter().find(|line| line["name"] == name).unwrap()["order"].clone()
    };
    // 40 units of 3 screws: two packs of a hundred.
    assert_eq!(line(&one, "bought", "screw-m2x4")["packs"], 1);
    assert_eq!(line(&many, "bought", "screw-m2x4")["packs"], 2);
    assert_eq!(line(&many, "bought", "screw-m2x4")["standard"], "ISO 7046-1");
    // 40 units of 2 wires of half a metre.
    assert_eq!(line(&many, "bought", "led-wire")["packs"], 4);
    // Both parts of a kit, which is on the first of both lines.
    let [a, b] = ["Solaris A", "Solaris B"].map(|name| line(&many, "liquids", name));
    assert_eq!((&a["kit"], &b["packs"], &b["cost_eur"]), (&b["kit"], &0.into(), &0.0.into()));
    assert!(a["packs"].as_u64() >= Some(1));
    assert!(many["costs"]["total_eur"].as_f64() > one["costs"]["total_eur"].as_f64());
}

const OWN: &str = "\
format: 1
extends: rtac0
name: own
buy:
  camera: {maker: Our shop, number: X-1, price: 30 EUR, source: our order of May}
  pan head screw ISO 7045 M1.6x5: {pack: 10 pieces, price: 2 EUR}
  Smooth-On Solaris: {price: 1 EUR}
";

#[test]
fn own_words_lie_over_the_list_by_piece_size_article_and_kit() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("own.yaml"), OWN).unwrap();
    let lab = "format: 1\nbuy:\n  dowel pin ISO 2338: {maker: Our dealer, pack: 5 pieces}\n";
    fs::write(root.path().join("lab.yaml"), lab).unwrap();
    let guide = |target: &str| {
        let mut command = command(root.path());
        let words = ["guide", target, "-o", "own", "--json"];
        let run = command.env("FABKIT_MATERIALS", "lab.yaml").args(words).output().unwrap();
        fabkit_tests::Run::from(run).ok().json()
    };
    let own = guide("own.yaml");
    let line = |guide: &Value, list: &str, name: &str| {
        let lines = guide[list].as_array().unwrap();
        lines.iter().find(|line| line["name"] == name).unwrap()["order"].clone()
    };
    let camera = line(&own, "bought", "camera");
    assert_eq!([&camera["maker"], &camera["number"]], ["Our shop", "X-1"]);
    assert_eq!([&camera["source"], &camera["price_source"]], ["our order of May", "own.yaml"]);
    let screw = line(&own, "bought", "screw-m1-6x5");
    assert_eq!([&screw["pack"], &screw["standard"]], ["10 pieces", "ISO 7045"]);
    assert_eq!(line(&own, "liquids", "Solaris A")["price_eur"], 1.0);
    // The design is the same: what it is bought from does not tell it apart.
    let usual = fabkit(root.path(), &["show", "rtac0", "--json"]).ok().json();
    let renamed = fabkit(root.path(), &["show", "own.yaml", "--json"]).ok().json();
    assert_eq!(usual["parameters"], renamed["parameters"]);
    // Fixtures are bought by the same words.
    let dowel = line(&guide("rtac0/semi-domes"), "bought", "dowel");
    assert_eq!([&dowel["maker"], &dowel["pack"]], ["Our dealer", "5 pieces"]);
}

#[test]
fn what_names_nothing_or_is_no_figure_is_refused_with_its_place() {
    let root = tempfile::tempdir().unwrap();
    for (buy, says) in [
        ("camrea: {price: 3 EUR}", "did you mean `camera`"),
        ("camera: {prise: 3 EUR}", "price"),
        ("camera: {price: 3}", "has no unit"),
        ("camera: {price: -3 EUR}", "0.01 EUR"),
        ("camera: {pack: 3 m}", "counted in pieces"),
        ("camera: {pack: 3 dozens}", "100 pieces"),
        ("stranded wire: {pack: 3 pieces}", "counted in mm"),
        ("Solaris A: {pack: 3 l}", "counted in g"),
        ("camera: 3", "no section"),
        ("camera: {extends: nothing}", "not known"),
    ] {
        let text = format!("format: 1\nextends: rtac0\nname: own\nbuy:\n  {buy}\n");
        fs::write(root.path().join("own.yaml"), text).unwrap();
        let run = fabkit(root.path(), &["guide", "own.yaml", "-o", "no"]);
        assert_eq!(run.code, Some(2), "{buy}: {run:?}");
        let told = format!("{run:?}");
        assert!(told.contains(says) && told.contains("own.yaml:5"), "{buy}: {told}");
        assert!(!root.path().join("no").exists());
    }
}
