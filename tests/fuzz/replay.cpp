// A fuzzer as a test: the seeds of a folder, and mutations of them, the same in every run.
//
// usage: fuzz_NAME FOLDER. Fails as the fuzzer does, by the signal of its trap; exit code 2 when there is no seed.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kMutations = 2000;

std::vector<Bytes> seeds_of(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Bytes> seeds;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return seeds;
}

/// Bytes changed, cut out, doubled, or taken from another seed.
Bytes mutated(Bytes bytes, const std::vector<Bytes>& seeds, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  const auto at = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  for (std::size_t times = 1 + below(4); times-- > 0;) {
    const std::size_t from = below(bytes.size() + 1);
    const std::size_t length = below(std::min<std::size_t>(bytes.size() - from, 16) + 1);
    switch (below(4)) {
      case 0:
        if (from < bytes.size()) bytes[from] = static_cast<std::uint8_t>(random());
        break;
      case 1:
        bytes.erase(bytes.begin() + at(from), bytes.begin() + at(from + length));
        break;
      case 2: {
        const Bytes piece(bytes.begin() + at(from), bytes.begin() + at(from + length));
        bytes.insert(bytes.begin() + at(from), piece.begin(), piece.end());
        break;
      }
      default: {
        const Bytes& other = seeds[below(seeds.size())];
        const std::size_t cut = below(other.size() + 1);
        bytes.resize(from);
        bytes.insert(bytes.end(), other.begin() + at(cut), other.end());
        break;
      }
    }
  }
  return bytes;
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<Bytes> seeds = count == 2 ? seeds_of(arguments[1]) : std::vector<Bytes>{};
  if (seeds.empty()) {
    std::fprintf(stderr, "usage: %s FOLDER, expected a folder of seeds\n", arguments[0]);
    return 2;
  }
  for (const Bytes& seed : seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());
  std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): the same in every run
  for (int i = 0; i < kMutations; ++i) {
    const Bytes input = mutated(seeds[static_cast<std::size_t>(i) % seeds.size()], seeds, random);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%zu seeds, %d mutations\n", seeds.size(), kMutations);
}
