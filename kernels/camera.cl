// Camera: the ray through a pixel.
//
// Camera space: the origin is the camera, x points right, y up and -z ahead; lengths are the
// world's. The host moves and turns the scene into it in float64, so that float32 rounds distances
// from the camera and not from the world's origin.

// 16 bytes as float32, 24 as float64. The screen stands one unit ahead.
typedef struct {
    real step[2];  // half the distance of two neighbouring pixels of a row, of a column
    int last[2];   // width - 1, height - 1, but at least 1
} Camera;

// Pixel (row i, column j) lies at x = linspace(-w, w, width)[j], y = linspace(h, -h, height)[i]
// (paper, section 11.1). 2 j - last is exact, so x and y are off by 2^-24 of themselves and the
// picture is symmetric to the last bit; linspace of one number is its start, here as well.
static Ray camera_ray(__global const Camera *camera, int column, int row) {
    reals x = TO_REALS(2 * (LANE + column) - camera->last[0]) * camera->step[0];
    reals y = (reals)((real)(camera->last[1] - 2 * row) * camera->step[1]);
    Ray ray = {vector(0, 0, 0), unit(vector(x, y, -1)), -1};
    return ray;
}
