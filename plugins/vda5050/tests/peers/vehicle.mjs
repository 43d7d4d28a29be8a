// A vehicle by the npm package vda-5050-lib 1.4.0 (its virtual AGV), for a master to steer.
// Usage: node vehicle.mjs mqtt://HOST:PORT MANUFACTURER SERIAL MAP NODE X Y [SPEED]
// (it begins at this node of the map). Install the package beside this file, or name its folder by
// NODE_PATH.
import { createRequire } from "node:module";
const require = createRequire(process.env.NODE_PATH ? process.env.NODE_PATH + "/" : import.meta.url);
const { AgvController, VirtualAgvAdapter } = require("vda-5050-lib");

const [url, manufacturer, serialNumber, mapId, lastNodeId, x, y, speed] = process.argv.slice(2);
const vehicle = new AgvController(
    { manufacturer, serialNumber },
    { interfaceName: "uagv", transport: { brokerUrl: url }, vdaVersion: "2.0.0" },
    { agvAdapterType: VirtualAgvAdapter, publishStateInterval: 1000, publishVisualizationInterval: 200 },
    {
        initialPosition: { mapId, x: Number(x), y: Number(y), theta: 0, lastNodeId },
        vehicleSpeed: Number(speed ?? 1),
        timeLapse: 1,
    });
await vehicle.start();
console.log(`${serialNumber} is at ${lastNodeId}`);
process.on("SIGTERM", () => vehicle.stop().then(() => process.exit(0)));
