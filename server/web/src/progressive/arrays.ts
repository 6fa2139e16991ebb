// Flat arrays that grow.

/** Array of numbers of one size. */
type Numbers = Float64Array | Uint32Array | Int32Array | Uint8Array;

/** The same array, or a longer one of the same numbers and then zeros. */
export function grown<A extends Numbers>(array: A, length: number): A {
  if (array.length >= length) return array;
  const longer = new (array.constructor as new (length: number) => A)(length);
  longer.set(array);
  return longer;
}
