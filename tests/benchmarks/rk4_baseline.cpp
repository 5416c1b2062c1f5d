// A plain C++ version of the direct model: what tablegen's speed is measured against.
//
// Panfilov & Tsirkunov 2022, equations (1)-(7), as someone would write them down who wants them
// fast but not clever: classical Runge-Kutta 4 for the flight in steps of 0.04 rad, a contact is
// seen at the end of a step and found by bisection, a collision is the root of one scalar equation
// between brackets. Lengths in a, velocities in the impact speed V, angular velocities in V / a,
// mass one; orientation is kept as the wall axes x and y (the normal) seen from the body.
//
//     g++ -std=c++17 -O3 -march=native rk4_baseline.cpp -o rk4_baseline
//     ./rk4_baseline mixture 45 200 100000 1
//
// prints one JSON object: microseconds of processor time per rebound, mean number of collisions,
// means of the state.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep = 0.04;           // rad per Runge-Kutta step
constexpr double kResolution = 1e-3;     // smallest rebound speed of a contact point, over V
constexpr double kClearance = 0.006;      // height over the reach at which a particle has left
constexpr double kContactDepth = 1e-12;  // a point this far below the wall touches it
constexpr double kTimeResolution = 1e-12;
constexpr double kTruncation = 0.5857864376269049;  // 2 - sqrt(2)
// Restitution (6) of corundum on steel and resistance (7).
constexpr double kCoefficient = 0.1, kExponent = 0.61;

struct Vec {
  double x, y, z;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec times(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec over(Vec a, Vec b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double norm(Vec a) { return std::sqrt(dot(a, a)); }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// --- Particles ---

enum Shape { kEllipsoid, kPrism, kTruncatedPrism, kTetrahedron };

struct Particle {
  Vec sizes, moments;
  std::vector<Vec> vertices;  // none for an ellipsoid
  double reach;
};

double second_moment(Shape shape) {
  if (shape == kPrism) return 1.0 / 3.0;
  if (shape != kTruncatedPrism) return 1.0 / 5.0;
  const double f = kTruncation, f3 = f * f * f;
  const double corner = (3.0 + (1.0 - f) * (1.0 - f) + (4.0 - f) * (4.0 - f)) / 20.0;
  return (1.0 / 3.0 - f3 * corner / 6.0) / (1.0 - f3 / 6.0);
}

// The particle is filled in place, so that its vertices are allocated once a run.
void make_particle(Shape shape, double b, double c, Particle& p) {
  p.sizes = {1.0, b, c};
  const Vec q = second_moment(shape) * times(p.sizes, p.sizes);
  p.moments = {q.y + q.z, q.z + q.x, q.x + q.y};
  p.vertices.clear();
  for (int corner = 0; corner < 8 && shape != kEllipsoid; ++corner) {
    const double x = corner & 1 ? -1.0 : 1.0, y = corner & 2 ? -1.0 : 1.0,
                 z = corner & 4 ? -1.0 : 1.0, left = 1.0 - kTruncation;
    if (shape == kTruncatedPrism) {
      p.vertices.push_back(times(p.sizes, {left * x, y, z}));
      p.vertices.push_back(times(p.sizes, {x, left * y, z}));
      p.vertices.push_back(times(p.sizes, {x, y, left * z}));
    } else if (shape == kPrism || x * y * z > 0.0) {
      p.vertices.push_back(times(p.sizes, {x, y, z}));
    }
  }
  p.reach = 1.0;
  for (const Vec& vertex : p.vertices) p.reach = std::max(p.reach, norm(vertex));
}

inline double lowest_height(const Particle& p, Vec n) {
  if (p.vertices.empty()) return -norm(times(p.sizes, n));
  double lowest = 0.0;
  for (const Vec& vertex : p.vertices) lowest = std::min(lowest, dot(vertex, n));
  return lowest;
}

Vec lowest_point(const Particle& p, Vec n) {
  if (p.vertices.empty()) {
    const Vec stretched = times(p.sizes, n);
    return (-1.0 / norm(stretched)) * times(p.sizes, stretched);
  }
  return *std::min_element(p.vertices.begin(), p.vertices.end(),
                           [n](Vec a, Vec b) { return dot(a, n) < dot(b, n); });
}

// --- Free flight: Euler's equations, and axes that rest in space ---

struct Turn {
  Vec spin, x, n;
};

inline Turn rate_of(Vec moments, const Turn& t) {
  return {over(cross(times(moments, t.spin), t.spin), moments), cross(t.x, t.spin),
          cross(t.n, t.spin)};
}

inline Turn advanced(const Turn& t, double dt, const Turn& rate) {
  return {t.spin + dt * rate.spin, t.x + dt * rate.x, t.n + dt * rate.n};
}

Turn turned(Vec moments, const Turn& t, double dt) {
  const Turn k1 = rate_of(moments, t);
  const Turn k2 = rate_of(moments, advanced(t, 0.5 * dt, k1));
  const Turn k3 = rate_of(moments, advanced(t, 0.5 * dt, k2));
  const Turn k4 = rate_of(moments, advanced(t, dt, k3));
  const Turn ends = advanced(advanced(t, dt / 6.0, k1), dt / 6.0, k4);
  return advanced(advanced(ends, dt / 3.0, k2), dt / 3.0, k3);
}

// Flies to the next contact (true), or until the centre is clear of the wall, kClearance above the reach (false).
bool fly(const Particle& p, Turn& turn, double height, double v) {
  double rate = norm(turn.spin);
  if (rate == 0.0 && v < 0.0) return true;  // falls without turning
  for (;;) {
    double dt = kStep / rate;
    const bool leaves = v > 0.0 && p.reach + kClearance - height <= v * dt;
    if (leaves) dt = (p.reach + kClearance - height) / v;
    Turn later = turned(p.moments, turn, dt);
    if (height + v * dt + lowest_height(p, later.n) < -kContactDepth) {
      double low = 0.0, high = dt;
      while (high - low > kTimeResolution) {
        const double middle = 0.5 * (low + high);
        const Turn between = turned(p.moments, turn, middle);
        const bool below = height + v * middle + lowest_height(p, between.n) < -kContactDepth;
        (below ? high : low) = middle;
      }
      turn = turned(p.moments, turn, high);
      return true;
    }
    turn = later;
    if (leaves) return false;
    height += v * dt;
    rate = norm(turn.spin);
  }
}

// --- One collision ---

struct Impact {
  double k, u_c, w_c;       // C_f / |V_c|, tangential contact velocity
  Vec to_x, to_y, to_z;     // rows of A: dV_c = A dV_p
};

// Impulse with normal part s: the tangential equations of (5) are linear.
inline Vec impulse_for(const Impact& i, double s) {
  const double ks = i.k * s;
  const double m11 = 1.0 + 0.5 * ks * i.to_x.x, m12 = 0.5 * ks * i.to_x.z,
               m22 = 1.0 + 0.5 * ks * i.to_z.z;
  const double r1 = -ks * (i.u_c + 0.5 * s * i.to_x.y), r2 = -ks * (i.w_c + 0.5 * s * i.to_z.y);
  const double det = m11 * m22 - m12 * m12;
  return {(m22 * r1 - m12 * r2) / det, s, (m11 * r2 - m12 * r1) / det};
}

// Root of f(s) = (A S(s))_n - jump by regula falsi with the Illinois modification.
Vec solve_impulse(const Impact& i, double jump) {
  const auto f = [&](double s) { return dot(i.to_y, impulse_for(i, s)) - jump; };
  double low = 0.0, high = jump, f_low = -jump, f_high = f(high);
  while (f_high < 0.0) {
    low = high, f_low = f_high;
    high *= 2.0, f_high = f(high);
  }
  for (int side = 0, n = 0; n < 100; ++n) {
    const double s = (f_low * high - f_high * low) / (f_low - f_high), f_s = f(s);
    if (std::abs(f_s) <= 1e-15 * jump || high - low <= 1e-15 * high) return impulse_for(i, s);
    if (f_s < 0.0) {
      low = s, f_low = f_s;
      if (side == -1) f_high *= 0.5;
      side = -1;
    } else {
      high = s, f_high = f_s;
      if (side == 1) f_low *= 0.5;
      side = 1;
    }
  }
  return impulse_for(i, high);
}

void collide(const Particle& p, double speed, Vec point, Vec& velocity, Turn& turn) {
  const Vec z = cross(turn.x, turn.n);
  const auto to_wall = [&](Vec a) { return Vec{dot(turn.x, a), dot(turn.n, a), dot(z, a)}; };
  const auto to_body = [&](Vec a) { return a.x * turn.x + a.y * turn.n + a.z * z; };
  const Vec arm = to_wall(point);
  const auto kick = [&](Vec s) { return over(to_body(cross(arm, s)), p.moments); };
  const auto response = [&](Vec s) { return s + cross(to_wall(kick(s)), arm); };  // (3), (4)

  const Vec contact = velocity + cross(to_wall(turn.spin), arm);  // (2)
  const double size = norm(contact), fall = -contact.y;
  const double loss = 1.0 - std::exp(-kCoefficient * std::pow(speed * size, kExponent));
  const double bounce = (1.0 - loss * fall / size) * fall;  // (6)
  const double c_f = std::exp(dot(arm, velocity) / (norm(arm) * norm(velocity)));  // (7)
  const Impact impact{c_f / size, contact.x, contact.z, response({1.0, 0.0, 0.0}),
                      response({0.0, 1.0, 0.0}), response({0.0, 0.0, 1.0})};
  Vec impulse = solve_impulse(impact, std::max(bounce, kResolution) + fall);
  // a bounce below the resolution is lifted to it, unless that adds energy: then it is elastic
  if (bounce < kResolution && dot(impulse, contact + 0.5 * response(impulse)) > 0.0)
    impulse = solve_impulse(impact, 2.0 * fall);
  velocity = velocity + impulse;
  turn.spin = turn.spin + kick(impulse);
}

// --- A run of random particles ---

struct Population {
  std::mt19937_64 engine;
  std::normal_distribution<double> normal{0.0, 1.0};

  double ratio() {
    for (;;) {
      const double value = 0.8 + 0.2 * normal(engine);
      if (value >= 0.5 && value <= 1.0) return value;
    }
  }

  Turn orientation() {
    double w = normal(engine), x = normal(engine), y = normal(engine), z = normal(engine);
    const double length = std::sqrt(w * w + x * x + y * y + z * z);
    w /= length, x /= length, y /= length, z /= length;
    return {{0.0, 0.0, 0.0},
            {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
            {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)}};
  }
};

struct Sums {
  double state[6] = {};
  double collisions = 0.0;
};

void run(int shape, double alpha, double speed, long count, std::uint64_t seed, Sums& sums) {
  Population population{std::mt19937_64(seed)};
  Particle particle;
  for (long i = 0; i < count; ++i) {
    const int kind = shape < 0 ? static_cast<int>(population.engine() >> 62) : shape;
    const double b = population.ratio(), c = b * population.ratio();
    make_particle(static_cast<Shape>(kind), b, c, particle);
    Turn turn = population.orientation();
    Vec velocity{std::cos(alpha), -std::sin(alpha), 0.0};
    double height = particle.reach;
    while (fly(particle, turn, height, velocity.y)) {
      const Vec point = lowest_point(particle, turn.n);
      height = -dot(point, turn.n);
      collide(particle, speed, point, velocity, turn);
      sums.collisions += 1.0;
    }
    const Vec z = cross(turn.x, turn.n);
    const double state[6] = {velocity.x,           velocity.y,           velocity.z,
                             dot(turn.x, turn.spin), dot(turn.n, turn.spin), dot(z, turn.spin)};
    for (int j = 0; j < 6; ++j) sums.state[j] += state[j];
  }
}

int shape_code(const std::string& name) {
  const char* names[] = {"mixture", "ellipsoid", "prism", "truncated-prism", "tetrahedron"};
  for (int i = 0; i < 5; ++i)
    if (name == names[i]) return i - 1;
  return -2;
}

double number(const char* text) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  return end != text && *end == '\0' ? value : std::nan("");
}

}  // namespace

int main(int argc, char** argv) {
  const int shape = argc == 6 ? shape_code(argv[1]) : -2;
  const double alpha_deg = argc == 6 ? number(argv[2]) : 0.0;
  const double speed = argc == 6 ? number(argv[3]) : 0.0;
  const double count = argc == 6 ? number(argv[4]) : 0.0;
  const double seed = argc == 6 ? number(argv[5]) : -1.0;
  if (shape < -1 || !(alpha_deg > 0.0 && alpha_deg <= 90.0) || !(speed > 0.0 && speed < 1e9) ||
      !(count >= 1.0 && count <= 1e12) || !(seed >= 0.0 && seed <= 1e15)) {
    std::fprintf(stderr,
                 "usage: rk4_baseline SHAPE ALPHA_DEG SPEED COUNT SEED\n"
                 "SHAPE: mixture, ellipsoid, prism, truncated-prism or tetrahedron; "
                 "0 < ALPHA_DEG <= 90; SPEED > 0 m/s; COUNT >= 1; SEED >= 0\n");
    return 2;
  }
  Sums sums;
  const std::clock_t start = std::clock();
  run(shape, alpha_deg * kPi / 180.0, speed, static_cast<long>(count),
      static_cast<std::uint64_t>(seed), sums);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const char* names[6] = {"u", "v", "w", "omega_x", "omega_y", "omega_z"};
  std::printf("{\"microseconds\": %.6f, \"collisions\": %.6f, \"mean\": {",
              1e6 * seconds / std::floor(count), sums.collisions / std::floor(count));
  for (int j = 0; j < 6; ++j)
    std::printf("%s\"%s\": %.8f", j ? ", " : "", names[j], sums.state[j] / std::floor(count));
  std::printf("}}\n");
  return 0;
}
