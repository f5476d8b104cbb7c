/** What a page served by `dehyst studio` may ask of it. The token came behind the # of the address, which no browser
 * sends; it goes out again in a header of every call, never in a cookie, which other servers would be sent too. */

const KEPT = "dehyst-studio";

export interface Log {
  id: string;
  name: string;
  bytes: number;
  refused: boolean;
  sheet?: string | undefined; // of a workbook, if one is named
}

export interface State {
  version: string;
  logs: Log[];
  limit: number;
  starts: string[];
  units: string[];
  families: { name: string; title: string }[];
  targets: { name: string; summary: string; reals: string[] }[];
}

export interface Progress {
  stage: string;
  done: number;
  of: number | null;
}

export interface Outcome<T> {
  result: T;
  files: Record<string, string>;
  command: string;
}

/** What dehyst says against a request, in its own words. */
export class Refusal extends Error {}

/** Whether this page is served by `dehyst studio`. */
export function served(): boolean {
  return document.querySelector('meta[name="dehyst-studio"]') !== null;
}

/** The token of the address, or what the key in it is worth: the browser that dehyst opens gets a key that serves once. */
async function token(): Promise<string> {
  const [, kind, secret] = /^#(studio|once)=([\w-]+)$/.exec(location.hash) ?? [];
  if (secret === undefined) return sessionStorage.getItem(KEPT) ?? "";
  history.replaceState(null, "", "#studio");
  const mine = kind === "studio" ? secret : ((await (await ask("enter", { method: "POST" }, secret)).json()) as { token: string }).token;
  sessionStorage.setItem(KEPT, mine); // a reload shall find it; other tabs and other servers do not
  return mine;
}

let mine: Promise<string> | null = null;

async function ask(path: string, options: RequestInit = {}, secret?: string): Promise<Response> {
  const bearer = secret ?? (await (mine ??= token()));
  let answer: Response;
  try {
    answer = await fetch(`/api/${path}`, { ...options, headers: { authorization: `Bearer ${bearer}` } });
  } catch (fault) {
    if (options.signal?.aborted) throw fault;
    throw new Refusal("The studio does not answer: it has ended. Start it again with dehyst studio, and use the address that it prints.");
  }
  if (answer.ok) return answer;
  const text = await answer.text();
  try {
    throw new Refusal((JSON.parse(text) as { error: string }).error);
  } catch (fault) {
    throw fault instanceof Refusal ? fault : new Refusal(text || `The studio answers with status ${answer.status}.`);
  }
}

export const state = async (): Promise<State> => (await (await ask("state")).json()) as State;

export async function upload(file: File, limit: number): Promise<Log> {
  if (file.size > limit) {
    throw new Refusal(`${file.name} has more than ${Math.round(limit / 2 ** 20)} MB, the most that the page copies. Name it on the command line, where it is read in place: dehyst studio LOG`);
  }
  return (await (await ask(`logs?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file })).json()) as Log;
}

export const file = async (id: string): Promise<Blob> => (await ask(`files/${id}`)).blob();

/** The address of a report, for a tab of its own. */
export const report = (id: string): string => `/report/${id}`;

/** Run a command; aborting the signal stops its process. */
export async function run<T>(command: string, given: Record<string, unknown>, signal: AbortSignal, told: (now: Progress) => void): Promise<Outcome<T>> {
  const answer = await ask(`run/${command}`, { method: "POST", body: JSON.stringify(given), signal });
  let typed = "";
  for await (const event of events(answer.body!)) {
    if (event.error !== undefined) throw new Refusal(event.error);
    if (event.command !== undefined) typed = event.command;
    else if (event.stage !== undefined) told(event as Progress);
    else if (event.result !== undefined) return { result: event.result as T, files: event.files ?? {}, command: typed };
  }
  throw new Refusal("The studio ended before the command did.");
}

interface Event extends Partial<Progress> {
  command?: string;
  error?: string;
  result?: unknown;
  files?: Record<string, string>;
}

async function* events(body: ReadableStream<Uint8Array>): AsyncGenerator<Event> {
  const reader = body.pipeThrough(new TextDecoderStream() as unknown as ReadableWritablePair<string, Uint8Array>).getReader();
  let rest = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const lines = (rest + value).split("\n");
    rest = lines.pop()!;
    for (const line of lines) if (line) yield JSON.parse(line) as Event;
  }
}

/** Stay connected as long as the page is open; call when the studio has ended. */
export async function stay(ended: () => void): Promise<void> {
  try {
    const reader = (await ask("alive")).body!.getReader();
    while (!(await reader.read()).done);
  } catch {
    // a connection that breaks has ended too
  }
  ended();
}
