export function begin(core: unknown): void;
export function read(data: Uint8Array, packed: Uint8Array, name: string, digest?: Promise<ArrayBuffer>): Promise<unknown>;
export function inspect(run: string | null): unknown;
export function identify(input: string, output: string, run: string | null, reading?: object, fitting?: object): unknown;
export function refusal(fault: unknown): { known: boolean; message: string; stack: string };
export function files(stem: string): { name: string; data: Uint8Array }[];
export function more(): unknown;
