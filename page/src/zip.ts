/** Files as a zip archive, stored as they are; dates are left at the beginning of time, so that the bytes tell the content. */

const TABLE = Uint32Array.from({ length: 256 }, (_v, n) => {
  let c = n;
  for (let k = 0; k < 8; k++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});
function crc32(data: Uint8Array): number {
  let c = 0xffffffff;
  for (let k = 0; k < data.length; k++) c = TABLE[(c ^ data[k]) & 0xff] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

export function zipped(files: { name: string; data: Uint8Array }[]): Uint8Array {
  const parts: Uint8Array[] = [];
  const directory: Uint8Array[] = [];
  let at = 0;
  for (const { name, data } of files) {
    const title = new TextEncoder().encode(name);
    const common = new DataView(new ArrayBuffer(26));
    [20, 0x0800, 0, 0, 0x21].forEach((value, k) => common.setUint16(2 * k, value, true));
    common.setUint32(10, crc32(data), true);
    common.setUint32(14, data.length, true);
    common.setUint32(18, data.length, true);
    common.setUint16(22, title.length, true);
    const shared = new Uint8Array(common.buffer);
    const head = Uint8Array.of(0x50, 0x4b, 3, 4, ...shared, ...title);
    const entry = new DataView(new ArrayBuffer(16));
    entry.setUint32(8, 0, true);
    entry.setUint32(12, at, true);
    directory.push(Uint8Array.of(0x50, 0x4b, 1, 2, 20, 3, ...shared, 0, 0, 0, 0, 0, 0, 0, 0, 0xa4, 0x81, ...new Uint8Array(entry.buffer).slice(12), ...title));
    parts.push(head, data);
    at += head.length + data.length;
  }
  const size = directory.reduce((sum, part) => sum + part.length, 0);
  const end = new DataView(new ArrayBuffer(22));
  end.setUint32(0, 0x06054b50, true);
  end.setUint16(8, files.length, true);
  end.setUint16(10, files.length, true);
  end.setUint32(12, size, true);
  end.setUint32(16, at, true);
  const all = new Uint8Array(at + size + 22);
  let place = 0;
  for (const part of [...parts, ...directory, new Uint8Array(end.buffer)]) {
    all.set(part, place);
    place += part.length;
  }
  return all;
}
