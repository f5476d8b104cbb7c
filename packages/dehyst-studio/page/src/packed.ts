/** Parts of the page that are carried compressed. */

const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";

/** Bytes of a text in base 85: five digits for four bytes, the last group as long as it is. */
function bytes85(text: string): Uint8Array {
  const digit = new Uint8Array(128);
  for (let k = 0; k < 85; k++) digit[DIGITS.charCodeAt(k)] = k;
  const whole = Math.ceil(text.length / 5);
  const out = new DataView(new ArrayBuffer(4 * whole));
  for (let g = 0; g < whole; g++) {
    let value = 0;
    for (let k = 5 * g; k < 5 * g + 5; k++) value = value * 85 + (k < text.length ? digit[text.charCodeAt(k)] : 84);
    out.setUint32(4 * g, value);
  }
  return new Uint8Array(out.buffer, 0, 4 * whole - (5 * whole - text.length));
}

/** What a packed part of the page holds. */
export async function unpacked(id: string): Promise<ArrayBuffer> {
  const packed = bytes85(document.getElementById(id)!.textContent!);
  return new Response(new Blob([packed as BlobPart]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
