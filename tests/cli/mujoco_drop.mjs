// Loads MJCF files with MuJoCo, drops each body on a plane and prints where it comes to rest, as JSON.
// usage: mujoco_drop.mjs MUJOCO_PACKAGE_FOLDER FILE...
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, ...files] = process.argv.slice(2);
const { default: load } = await import(pathToFileURL(`${folder}/mujoco.js`));
const mujoco = await load();

/**
 * Starts tilted just above the plane. Thick air takes the energy of rocking and rolling; MuJoCo's soft friction would let round bodies
 * creep on at millimetres a second for minutes, which its solver's iterations against slip prevent.
 */
function dropped(text) {
    const scene = text.replace("<worldbody>",
        `<option timestep="0.002" density="60" viscosity="200" noslip_iterations="5"/>
        <worldbody><geom name="ground" type="plane" size="50 50 1" condim="6" friction="1 0.05 0.05"/>`);
    const model = mujoco.MjModel.from_xml_string(scene);
    const data = new mujoco.MjData(model);
    data.qpos.set([0, 0, 6, 0.9, 0.3, 0.2, 0.1]);
    let steps = 0;
    for (let still = 0; steps < 40000 && still < 500; ++steps) {
        mujoco.mj_step(model, data);
        still = Math.hypot(...data.qvel) < 1e-3 ? still + 1 : 0;
    }
    const answer = { geoms: model.ngeom - 1, position: [...data.qpos.slice(0, 3)], quaternion: [...data.qpos.slice(3, 7)],
        speed: Math.hypot(...data.qvel), steps };
    data.delete();
    model.delete();
    return answer;
}

console.log(JSON.stringify(files.map((file) => dropped(readFileSync(file, "utf8")))));
