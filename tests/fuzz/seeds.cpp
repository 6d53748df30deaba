// seeds CORPUS: hands every seed of every fuzz target to it, and a few damaged copies of each: the same ones each time. What
// libFuzzer does for hours (tests/fuzz.sh) in seconds, without the build that it needs.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include "fuzz.h"

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// Cuts, doubles, removes or changes a few bytes.
void damage(Bytes& bytes, std::mt19937& random) {
  for (auto times = 1 + random() % 3; times > 0 && !bytes.empty(); --times) {
    const auto at = static_cast<std::ptrdiff_t>(random() % bytes.size());
    const auto length = static_cast<std::ptrdiff_t>(
        std::min<std::size_t>(1 + random() % 16, bytes.size() - static_cast<std::size_t>(at)));
    switch (random() % 6) {
      case 0:
        bytes.resize(static_cast<std::size_t>(at));
        break;
      case 1:
        bytes.erase(bytes.begin() + at, bytes.begin() + at + length);
        break;
      case 2: {
        const Bytes piece(bytes.begin() + at, bytes.begin() + at + length);
        bytes.insert(bytes.begin() + at, piece.begin(), piece.end());
        break;
      }
      case 3:
        bytes[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(random());
        break;
      case 4:
        bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1u << random() % 8);
        break;
      default:
        std::fill_n(bytes.begin() + at, length, random() % 2 == 0 ? std::uint8_t{0} : std::uint8_t{255});
    }
  }
}

// By their names.
std::map<std::string, Bytes> seeds_of(const fs::path& corpus, const std::string& name,
                                      const gpvc::fuzz::Target& target) {
  std::map<std::string, Bytes> seeds;
  if (fs::is_directory(corpus / name))
    for (const fs::directory_entry& entry : fs::directory_iterator(corpus / name))
      seeds[entry.path().filename()] = bytes_of(entry.path());
  if (target.seeds != nullptr)
    for (std::size_t number = 0; const std::string& seed : target.seeds(corpus))
      seeds["made " + std::to_string(number++)] = Bytes(seed.begin(), seed.end());
  return seeds;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: seeds CORPUS\n", stderr);
    return 2;
  }
  std::size_t inputs = 0, seeds = 0;
  for (const auto& [name, target] : gpvc::fuzz::targets()) {
    const std::map<std::string, Bytes> all = seeds_of(argv[1], name, target);
    if (all.empty()) {
      std::fprintf(stderr, "%s has no seed in %s\n", name.c_str(), argv[1]);
      return 1;
    }
    // Those that use what they read take a hundred times as long.
    const int copies = target.seeds == nullptr ? 200 : 20;
    for (const auto& [seed_name, seed] : all) {
      std::mt19937 random(1);
      // Said before: a finding ends the program.
      std::fprintf(stderr, "%s %s\n", name.c_str(), seed_name.c_str());
      for (int copy = 0; copy <= copies; ++copy) {
        Bytes bytes = seed;
        if (copy > 0) damage(bytes, random);
        target.run(bytes.data(), bytes.size());
        ++inputs;
      }
      ++seeds;
    }
  }
  std::printf("%zu targets, %zu seeds, %zu inputs, no finding\n", gpvc::fuzz::targets().size(), seeds, inputs);
  return 0;
}
