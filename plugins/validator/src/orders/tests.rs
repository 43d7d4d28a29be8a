//! The room that orders take.

use regatta_plugin::World;

use super::*;

#[test]
fn orders_that_are_over_take_no_room_and_are_still_known() {
    let (mut orders, mut findings) = (Orders::default(), Findings::new(1));
    let world = WorldModel::new(&World::default());
    let mut log = |tick: u64, kind: OrderKind, number: u64, findings: &mut Findings| {
        let header = OrderHeader { tick, sequence: tick, ..OrderHeader::default() };
        orders.take(&header, &[OrderRecord::new(number, kind)], false);
        let now = Now { tick, seconds: tick as f64, period: 1.0 };
        orders.judge(now, &world, &Stands::default(), findings);
        (orders.orders.len(), orders.len())
    };
    for number in 1..=1000 {
        log(2 * number - 1, OrderKind::Created, number, &mut findings);
        let open_and_all = log(2 * number, OrderKind::Cancelled, number, &mut findings);
        assert_eq!(open_and_all, (0, number));
    }
    assert_eq!(findings.count(Kind::DoneTwice), 0);
    log(2001, OrderKind::Finished, 500, &mut findings);
    assert_eq!(findings.count(Kind::DoneTwice), 1);
}
