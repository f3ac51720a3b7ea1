// The operations of the core's fixed-point number beside those of libfixmath (Q16.16), on the same inputs: both hold each of them
// exactly, and the results are in the range of both.
//
// usage: fixmath                    the errors of each operation, worst and mean
//        fixmath OPERATION WHO      that operation of that library alone, kCalls times, for callgrind: fixmath.py
#include <libfixmath/fixmath.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

#include "firmware/numeric/scalar.hpp"
#include "tests/bench/row.hpp"

namespace {

using plenum::numeric::Fixed;

constexpr int kCalls = 100'000;
constexpr double kUnits = 65536;  // of Q16.16 in 1

struct Inputs {
  fix16_t a = 0, b = 0;
  Fixed wide_a = 0, wide_b = 0;
};

Inputs inputs(double a, double b) {
  Inputs made;
  made.a = static_cast<fix16_t>(std::lround(a * kUnits));
  made.b = static_cast<fix16_t>(std::lround(b * kUnits));
  made.wide_a = Fixed::from_raw(std::int64_t{made.a} * 65536);
  made.wide_b = Fixed::from_raw(std::int64_t{made.b} * 65536);
  return made;
}

struct Operation {
  std::string_view name;
  Inputs (*draw)(std::mt19937&);
  Fixed (*ours)(const Inputs&);
  fix16_t (*theirs)(const Inputs&);
  long double (*exact)(long double a, long double b);
};

double between(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
double magnitude(std::mt19937& random, double low, double high) {  // every decade alike
  return std::exp(between(random, std::log(low), std::log(high)));
}

constexpr std::array kOperations = {
    Operation{"product",
              [](std::mt19937& random) {
                return inputs(magnitude(random, 0.001, 100), between(random, -300, 300));
              },
              [](const Inputs& x) { return x.wide_a * x.wide_b; },
              [](const Inputs& x) { return fix16_mul(x.a, x.b); },
              [](long double a, long double b) { return a * b; }},
    Operation{"quotient",
              [](std::mt19937& random) {
                return inputs(between(random, -300, 300), magnitude(random, 0.01, 1000));
              },
              [](const Inputs& x) { return x.wide_a / x.wide_b; },
              [](const Inputs& x) { return fix16_div(x.a, x.b); },
              [](long double a, long double b) { return a / b; }},
    Operation{"root", [](std::mt19937& random) { return inputs(magnitude(random, 0.001, 30000), 0); },
              [](const Inputs& x) { return sqrt(x.wide_a); }, [](const Inputs& x) { return fix16_sqrt(x.a); },
              [](long double a, long double) { return std::sqrt(a); }},
    Operation{"exponential", [](std::mt19937& random) { return inputs(-magnitude(random, 0.001, 10), 0); },
              [](const Inputs& x) { return Fixed(1) - decay(-x.wide_a); },
              [](const Inputs& x) { return fix16_exp(x.a); },
              [](long double a, long double) { return std::exp(a); }},
};

std::vector<Inputs> drawn(const Operation& operation) {
  std::mt19937 random(1);
  std::vector<Inputs> all(kCalls);
  std::generate(all.begin(), all.end(), [&] { return operation.draw(random); });
  return all;
}

struct Error {
  double worst = 0, mean = 0;
  void take(long double error) {
    worst = std::max(worst, static_cast<double>(std::fabs(error)));
    mean += static_cast<double>(std::fabs(error)) / kCalls;
  }
};

void print_errors(const Operation& operation) {
  Error ours, theirs;
  for (const Inputs& x : drawn(operation)) {
    const long double exact =
        operation.exact(x.a / static_cast<long double>(kUnits), x.b / static_cast<long double>(kUnits));
    ours.take(static_cast<long double>(operation.ours(x).raw()) * 0x1p-32L - exact);
    theirs.take(operation.theirs(x) / static_cast<long double>(kUnits) - exact);
  }
  const auto row = [&](const char* what, double value, double peer) {
    plenum::bench::print({.name = fmt::format("fixed.operation_{}_error_{}", operation.name, what),
                          .value = value,
                          .unit = "1",
                          .peer = "libfixmath",
                          .peer_value = peer});
  };
  row("worst", ours.worst, theirs.worst);
  row("mean", ours.mean, theirs.mean);
}

}  // namespace

// What callgrind counts within.
extern "C" [[gnu::noinline]] void counted_ours(const Operation& operation, const Inputs& x,
                                               std::int64_t& sum) {
  sum += operation.ours(x).raw();
}
extern "C" [[gnu::noinline]] void counted_theirs(const Operation& operation, const Inputs& x,
                                                 std::int64_t& sum) {
  sum += operation.theirs(x);
}

int main(int count, char** words) {
  if (count == 1) {
    for (const Operation& operation : kOperations) print_errors(operation);
    return 0;
  }
  if (count != 3) return 2;
  const auto* const operation = std::find_if(kOperations.begin(), kOperations.end(),
                                             [&](const Operation& o) { return o.name == words[1]; });
  if (operation == kOperations.end()) return 2;
  const bool ours = std::string_view(words[2]) == "ours";
  std::int64_t sum = 0;
  for (const Inputs& x : drawn(*operation))
    ours ? counted_ours(*operation, x, sum) : counted_theirs(*operation, x, sum);
  return sum == 1 ? 1 : 0;  // it is used
}
