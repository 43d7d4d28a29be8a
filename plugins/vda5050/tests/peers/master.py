"""A master by the PyPI package vda5050-sdk 0.2.0 (with aiomqtt) drives an order with an action, extends it,
cancels another one, and sees an error. All messages of the vehicle are checked by the package's own schemas.

Usage: python master.py mqtt://HOST:PORT MANUFACTURER SERIAL NODE NODE NODE
(nodes of a layout whose edges are called NODE-NODE)
"""

import asyncio
import sys
import time

from vda5050 import Action, BlockingType, MasterClient, MasterConfig, OrderBuilder

url, manufacturer, serial, a, b, c = sys.argv[1:]
target = f"{manufacturer}/{serial}"
states = []
failed = False
run = f"py-{time.time():.0f}-"


def order(order_id, nodes, action=None):
    builder = OrderBuilder(order_id=order_id, manufacturer=manufacturer, serial_number=serial)
    builder.add_node(nodes[0], released=True)
    for start, end in zip(nodes, nodes[1:]):
        builder.add_edge(start, end, edge_id=f"{start}-{end}", released=True)
        builder.add_node(end, released=True, actions=[action] if action and end == b else [])
    return builder.build()


async def wait(what, is_met):
    global failed
    for _ in range(750):
        if states and is_met(states[-1]):
            print(f"ok: {what}")
            return
        await asyncio.sleep(0.02)
    failed = True
    print(f"FAILED: {what}: {states[-1] if states else None}")


def is_done(state, order_id):
    return state.order_id == order_id and not state.node_states


def master():
    """A client of its own for each order: one client sends no second order to a vehicle."""
    config = MasterConfig(broker_url=url, protocol_version="2.0.0", validate_messages=True)
    client = MasterClient(config)
    client.on_state(lambda state, key: states.append(state))
    return client


async def main():
    async with master() as client:
        await wait("the vehicle tells its state", lambda state: state.last_node_id != "")
        pick = Action(action_id="pick-1", action_type="pick", blocking_type=BlockingType.HARD)
        await client.dispatch(order(run + "1", [a, b, c], pick), target=target)
        await wait("an order is driven to its end", lambda state: is_done(state, run + "1"))
        await wait("its action is finished", lambda state: any(it.action_status.value == "FINISHED" for it in state.action_states))
    async with master() as client:
        await client.dispatch(order(run + "2", [c, a, b]), target=target)
        await wait("the next order begins", lambda state: state.order_id == run + "2" and state.driving)
        await client.cancel_order(target)
        await wait("it is cancelled", lambda state: is_done(state, run + "2") and not state.driving)
        here = states[-1].last_node_id
    async with master() as client:
        await client.dispatch(order(run + "3", [here, "nowhere"]), target=target)
        await wait("an order to nowhere is an error", lambda state: state.errors and state.errors[0].error_type == "noRouteError")


asyncio.run(main())
sys.exit(failed)
