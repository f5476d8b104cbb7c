/** Unpacks the program and runs it: the policy of the page allows that text, by its hash, and no other. */

import { unpacked } from "./packed";

void unpacked("program").then((bytes) => {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(bytes);
  document.body.append(script);
});
