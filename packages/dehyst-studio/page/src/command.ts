/** Lines of dehyst as they are typed into a shell; the rules are those of dehyst.shell. */

const PLAIN = /^[A-Za-z0-9_./:+-][A-Za-z0-9_./:=+-]*$/;
const SPECIAL = /["$`!\\]/; // some shell reads these between double quotes too

/** A word that arrives as it is. */
export function quoted(word: string, windows = /Windows/.test(navigator.userAgent)): string {
  if (windows) return PLAIN.test(word.replaceAll("\\", "/")) ? word : `"${word.replace(/(\\*)"/g, '$1$1\\"').replace(/\\+$/, "$&$&")}"`;
  if (PLAIN.test(word)) return word;
  return SPECIAL.test(word) ? `'${word.replaceAll("'", `'"'"'`)}'` : `"${word}"`;
}

/** `dehyst COMMAND LOG --option value ...`; a value that begins with a dash is joined to its option. */
export function typed(command: string, log: string, options: Record<string, string>): string {
  const words = ["dehyst", command, log.startsWith("-") ? `./${log}` : log];
  for (const [name, value] of Object.entries(options)) {
    if (value.startsWith("-")) words.push(`--${name}=${value}`);
    else words.push(`--${name}`, value);
  }
  return words.map((word) => quoted(word)).join(" ");
}
