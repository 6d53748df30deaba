// damage FILE SEED bytes|hash|cut: damages a file of a result, a job or a checkpoint, for tests/trust.sh. The same seed damages the same
// place. bytes: other values at one place, the size is kept; hash: the same within what io::WorkStore keeps, whose hash is
// made right again, so that only its values can tell (bytes, where the file holds no hash); cut: a part of the file is lost.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::filesystem::path path = argv[1];
  std::mt19937_64 random(std::stoull(argv[2]));
  const std::string kind = argv[3];
  std::ifstream in(path, std::ios::binary);
  std::vector<unsigned char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (bytes.empty()) return 3;

  // io/files/work_store.cpp: a head of 8 + 16 bytes, the values, and their hash.
  constexpr std::size_t head = 24, tail = 16;
  const bool stored = bytes.size() > head + tail && std::memcmp(bytes.data(), "gpvcwor1", 8) == 0;
  std::size_t first = 0, count = bytes.size();
  if (kind == "hash" && stored) first = head, count -= head + tail;
  std::size_t at = first + random() % count;
  if (kind == "cut") {
    bytes.resize(at);
  } else {
    // A value of up to eight bytes: noise, the least, the greatest, or one bit.
    const std::size_t width = std::min<std::size_t>(std::size_t{1} << (random() % 4), first + count - at);
    const auto how = random() % 4;
    for (std::size_t k = 0; k < width; ++k)
      bytes[at + k] = static_cast<unsigned char>(how == 0 ? random() : how == 1 ? 0 : how == 2 ? 0xff : bytes[at + k]);
    if (how == 3) bytes[at] ^= static_cast<unsigned char>(1u << (random() % 8));
  }
  if (kind == "hash" && stored) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data() + head, bytes.size() - head - tail);
    std::memcpy(bytes.data() + bytes.size() - tail, &hash.low64, 8);
    std::memcpy(bytes.data() + bytes.size() - tail + 8, &hash.high64, 8);
  }
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  std::cout << path.string() << ": " << kind << " at byte " << at << " of " << bytes.size() << '\n';
  return out.flush() ? 0 : 1;
}
