// What the Khronos glTF validator says of files: a line each, exit 1 if it has an error or a warning, 3 if it is missing.
//
//     NODE_PATH=FOLDER/node_modules node gltf_valid.cjs FILE...
const fs = require("fs");
let validator;
try {
  validator = require("gltf-validator");
} catch (missing) {
  console.log("missing: gltf-validator");
  process.exit(3);
}
(async () => {
  let sound = true;
  for (const path of process.argv.slice(2)) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)));
    sound = sound && issues.numErrors === 0 && issues.numWarnings === 0;
    console.log(`${path}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
    for (const message of issues.messages) console.log(`  ${message.code} at ${message.pointer}: ${message.message}`);
  }
  process.exit(sound ? 0 : 1);
})();
