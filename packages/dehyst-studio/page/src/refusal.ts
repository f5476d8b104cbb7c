/** What the page does not do, in a sentence, and the command that does it. */

import { typed } from "./command";

export class Refusal extends Error {
  /** `command`: what to type instead, "" if there is nothing better. */
  constructor(message: string, readonly command = "") {
    super(message);
  }
}

/** A log that the page does not understand with certainty: Python says what it holds. */
export function unclear(log: string, reason: string): Refusal {
  return new Refusal(`${reason} This page reads plain tables only and does not guess. In a terminal, dehyst says what the log holds and how to read it:`,
    typed("inspect", log, {}));
}
