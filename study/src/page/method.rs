//! The paragraphs on the method of a study.

use crate::answer::{Answer, Method};

/// Returns the paragraphs on the method.
pub(super) fn method(answer: &Answer) -> Vec<String> {
    let span = if answer.method.is_day { day() } else { warm_up(answer) };
    let question = match answer.method.targets.is_empty() {
        true => knee(&answer.method),
        false => least(&answer.method),
    };
    let seeds = "Seeds are common random numbers: variants and reliefs get the same orders and \
                 disturbances, and differences are paired, seed by seed (Law, 10.2.1 and 11.2).";
    let mut paragraphs = vec![
        runs(answer),
        ticks(),
        span,
        intervals(&answer.method),
        seeds.to_owned(),
        question,
        bottlenecks(),
    ];
    paragraphs.extend(reliefs(answer));
    paragraphs
}

fn runs(answer: &Answer) -> String {
    let method = &answer.method;
    let minutes = method.secs as f64 / 60.0;
    format!(
        "Regatta {}. Each run is the real engine with the fleet manager, the validator, and \
         meters of traffic and orders in lockstep: {minutes:.0} simulated minutes{} at {} ticks a \
         second. A run repeats bit by bit; `runs` in `study.sqlite` has the command and the digest \
         of each.",
        answer.program,
        if method.is_day { " at most" } else { "" },
        method.rate_hz,
    )
}

fn ticks() -> String {
    "Robots arrive, end turns and get orders at ticks: each of these takes up to a tick longer than \
     in continuous time, a bias that intervals don't contain. At ten ticks a second, an order \
     takes up to 0.1 s longer for each of its stops and for each turn on the spot."
        .to_owned()
}

fn day() -> String {
    "A day is a terminating simulation: robots are idle at its beginning, nothing is cut off, and \
     figures are those of all orders, up to the end of the last one (Law, Simulation Modeling and \
     Analysis, 5th edition, 9.4). Orders that are open at the limit count with their time so far, \
     and such a day meets no target. A day that is drawn from blocks of time is drawn by the local \
     block bootstrap: each block gets the orders of itself or of one of its two neighbours \
     (Paparoditis and Politis, Comptes Rendus de l'Académie des Sciences 335, 2002)."
        .to_owned()
}

fn warm_up(answer: &Answer) -> String {
    let points = answer.variants.iter().flat_map(|variant| &variant.points);
    let times = points.filter_map(|point| point.warm_up_secs);
    let longest = times.map(|interval| interval.mean).fold(0.0, f64::max);
    format!(
        "Warm-up: cut off by MSER-5 on the orders finished in each ten seconds (White, Simulation \
         69, 1997; White, Cobb and Spratt, Winter Simulation Conference, 2000); at most \
         {longest:.0} s on average over the seeds of a point."
    )
}

fn intervals(method: &Method) -> String {
    let ([least, most], interval) = (method.seeds, method.interval * 100.0);
    let more = match method.targets.is_empty() {
        true => format!("at the knee up to {most}, until the interval is within ± {interval:.0} %"),
        false => format!("up to {most} where the interval contains a limit"),
    };
    format!(
        "Intervals are Student's at 95 % over independent replications (Law, Simulation Modeling \
         and Analysis, 5th edition, 9.4.1): {least} seeds a point, and {more}."
    )
}

fn knee(method: &Method) -> String {
    let knee = method.knee * 100.0;
    format!(
        "The knee: robots are doubled, then the distance round the knee is halved again and again. \
         On the upper concave hull of the means, it is the first point from which on each more \
         robot brings less than {knee:.0} % of what one brings alone."
    )
}

fn least(method: &Method) -> String {
    let targets = method.targets.join("', '");
    format!(
        "The least number: robots are doubled until a number meets '{targets}', then the distance \
         to the largest number below that doesn't is halved until they are neighbours, and the two \
         numbers on either side of the answer are run, too. A number meets a target if all of the \
         95 % interval of the mean over its runs does. To meet all targets, it must meet each, \
         which needs no wider intervals (the intersection-union test: Berger, Technometrics 24, \
         1982). Runs with a stall, and days that aren't over at their limit, meet none."
    )
}

fn bottlenecks() -> String {
    "A robot that stands and wants to drive on is kept out of the next edge of its way, and those \
     behind it are kept back by it: so all of a queue waits for the edge that its head is kept out \
     of, and for the node where that ends. 'Robots waiting for it' is their mean number. It is \
     measured by where robots are and where they go next, whoever steers them. 'Of all waiting': \
     the rest of the time they wait for other places, or where their manager keeps them, for no \
     place that can be seen. Doors and lifts count as well as robots."
        .to_owned()
}

fn reliefs(answer: &Answer) -> Option<String> {
    let reliefs = answer.chosen.reliefs.as_ref()?;
    let [least, most] = answer.method.seeds;
    let count = reliefs.tried.len().max(1);
    Some(format!(
        "What would help: candidates come from where the time goes (waiting for a place, an \
         operator, a track or an edge, driving slowly or round about, charging, repairs), each \
         with the mean number of robots whose time it is about; the largest of each kind comes \
         first. They run a race (Maron and Moore, Hoeffding races, 1994): all begin with {least} \
         seeds, the same as without a change; after each round, those leave whose paired \
         difference to the best is surely against them, or which surely bring under 1 %; the \
         others get one more seed, up to {most}. 'Surely' and 'within chance' are by paired \
         Student's intervals that hold for all {count} after each round together with 95 % \
         confidence (Bonferroni; Law, 9.7). New roads are drawn where the \
         layout has no other ones: walls and the price are yours to judge."
    ))
}
