//! Times the computation of ground truth, for comparison with Python (`fabkit/python/benches/overhead.py`): casts a
//! press of the R-Tac0 `COUNT` times, `cast_time PRESS COUNT`, and prints the milliseconds of each.

use std::sync::Arc;
use std::time::Instant;

use fabkit_application::Error;
use fabkit_application::ground_truth::arrays;
use fabkit_application::press_simulation::ContactModel;
use fabkit_application::scene::{Cast, SensorView, viewpoint_from_files};
use fabkit_application::source::Source;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let press = arguments.next().unwrap_or("semi-dome-017".into());
    let count: usize = arguments.next().unwrap_or("20".into()).parse()?;
    let project = Source::find("rtac0")?.load(&[])?;
    let viewpoint = viewpoint_from_files(&project, None, None)?;
    let scene = SensorView::new(Arc::new(project), viewpoint)?;
    for _ in 0..count {
        let start = Instant::now();
        let presses = [scene.project.press(&press)?];
        let cast = Cast {
            presses: &presses,
            samples: 1,
            contact: ContactModel::Rigid,
            shear_mm: [0.0; 2],
            print_sigma_mm: 0.05,
            allow_no_contact: false,
        };
        let seen = scene.cast(&cast, 0, |seen| Ok::<_, Error>(arrays(seen.map, seen.sigmas)))?;
        drop(std::hint::black_box(seen));
        println!("{}", 1e3 * start.elapsed().as_secs_f64());
    }
    Ok(())
}
