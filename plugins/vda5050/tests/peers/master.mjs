// A master by the npm package vda-5050-lib 1.4.0 drives an order, updates it, cancels another one,
// and sees an error. Usage: node master.mjs mqtt://HOST:PORT MANUFACTURER SERIAL NODE NODE NODE
// (nodes of a layout whose edges are called NODE-NODE). Install the package beside this file, or
// name its folder by NODE_PATH.
import { createRequire } from "node:module";
const require = createRequire(process.env.NODE_PATH ? process.env.NODE_PATH + "/" : import.meta.url);
const { MasterController, BlockingType } = require("vda-5050-lib");

const [url, manufacturer, serialNumber, ...names] = process.argv.slice(2);
const agv = { manufacturer, serialNumber };
const master = new MasterController(
    { interfaceName: "uagv", transport: { brokerUrl: url }, vdaVersion: "2.0.0" }, {});

function order(orderId, orderUpdateId, first, nodes, action) {
    const node = (nodeId, index) => ({
        nodeId, sequenceId: first + 2 * index, released: true,
        actions: action && index === 1 ? [action] : [],
    });
    const edge = (start, index) => ({
        edgeId: `${start}-${nodes[index + 1]}`, sequenceId: first + 2 * index + 1, released: true,
        startNodeId: start, endNodeId: nodes[index + 1], actions: [],
    });
    return { orderId, orderUpdateId, nodes: nodes.map(node), edges: nodes.slice(0, -1).map(edge) };
}

function assign(order, after) {
    const events = [];
    return new Promise((resolve) => master.assignOrder(agv, order, {
        onOrderProcessed: (error, byCancelation, active) => {
            if (!active) resolve({ error, byCancelation, events });
        },
        onNodeTraversed: (node) => events.push(`node ${node.nodeId}`),
        onEdgeTraversed: (edge) => events.push(`edge ${edge.edgeId}`),
        onEdgeTraversing: () => after && after(),
        onActionStateChanged: (state) => events.push(`action ${state.actionStatus}`),
    }));
}

function instant(actionType) {
    const action = { actionId: actionType, actionType, blockingType: BlockingType.None };
    return new Promise((resolve) => master.initiateInstantActions(agv, { instantActions: [action] }, {
        onActionStateChanged: (state) => {
            if (["FINISHED", "FAILED"].includes(state.actionStatus)) resolve(state.actionStatus);
        },
        onActionError: (error) => resolve(error.errorType),
    }));
}

function expect(what, is) {
    console.log(`${is ? "ok" : "FAILED"}: ${what}`);
    if (!is) process.exitCode = 1;
}

await master.start();
await new Promise((resolve) => master.trackAgvs((id, state) => state === "ONLINE" && resolve()));
expect("the vehicle is online", true);
await new Promise((resolve) => setTimeout(resolve, 1500));
const [a, b, c] = names;
const pick = { actionId: "pick", actionType: "pick", blockingType: BlockingType.Hard };
const done = await assign(order("one", 0, 0, [a, b, c], pick));
console.log(done.events.join(", "));
expect("an order is driven to its end",
    !done.error && !done.byCancelation && done.events.includes("action FINISHED"));
const updated = await assign(order("one", 1, 4, [c, a]));
expect("an update is driven to its end", !updated.error && updated.events.includes(`node ${a}`));
let cancelling;
const cancelled = await assign(order("two", 0, 0, [a, b, c]), () => {
    cancelling ??= instant("cancelOrder");
});
expect("an order is cancelled", cancelled.byCancelation && await cancelling === "FINISHED");
const wrong = await assign(order("three", 0, 0, [c, "nowhere"]));
expect(`an order to nowhere is an error: ${wrong.error?.errorType}`,
    wrong.error?.errorType === "noRouteError");
await master.stop();
process.exit();
