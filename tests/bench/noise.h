/* noise.h - what the figures grow clouds, smoke and hills from. Include it after pt.h. */
#ifndef NOISE_H
#define NOISE_H

static float noise_at(int x, int y, int z) { return pti_u01(pti_hash2((uint32_t)x, pti_hash2((uint32_t)y, (uint32_t)z * 3 + 1))); }
static float noise(float x, float y, float z) {          /* trilinear between lattice values, smoothed: 0 to 1 */
    int i = (int)floorf(x), j = (int)floorf(y), k = (int)floorf(z), c;
    float u = x - (float)i, v = y - (float)j, w = z - (float)k, sum = 0;
    u *= u * (3 - 2 * u); v *= v * (3 - 2 * v); w *= w * (3 - 2 * w);
    for (c = 0; c < 8; c++)
        sum += (c & 1 ? u : 1 - u) * (c & 2 ? v : 1 - v) * (c & 4 ? w : 1 - w) *
               noise_at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
    return sum;
}
static inline float noise_sum(float x, float y, float z, int octaves) {      /* about -1/2 to 1/2 */
    float sum = 0, size = .5f;
    int k;
    for (k = 0; k < octaves; k++, size *= .5f, x = 2.03f * x + 17, y = 2.03f * y + 5, z = 2.03f * z + 11)
        sum += size * (noise(x, y, z) - .5f);
    return sum;
}
#endif
