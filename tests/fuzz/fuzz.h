// What the libFuzzer targets share. All are in one program, which links once; GPVC_FUZZ_TARGET in the environment names
// the one to run. A target hands bytes to a reader as the file or folder a user would; the reader returns, or throws
// InputError with one sentence. Anything else (a crash, a sanitizer's finding, another exception, a huge allocation, a
// hang) is a finding.
#pragma once

#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"

namespace gpvc::fuzz {

/// A folder of this process alone, in memory where the system has such a place.
inline const std::filesystem::path& folder() {
  // Never destroyed: what runs at exit removes it.
  static const auto& kFolder = *new std::filesystem::path([] {
    const std::filesystem::path shm = "/dev/shm";
    const std::filesystem::path base = access(shm.c_str(), W_OK) == 0 ? shm : std::filesystem::temp_directory_path();
    std::filesystem::path made = base / ("gpvc-fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] { std::filesystem::remove_all(folder()); });
    return made;
  }());
  return kFolder;
}

inline std::filesystem::path write(const std::string& name, std::string_view bytes) {
  const std::filesystem::path file = folder() / name;
  std::FILE* out = std::fopen(file.c_str(), "wb");
  if (out == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), out) != bytes.size() || std::fclose(out) != 0)
    std::abort();
  return file;
}

inline std::string_view view(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Two files in one input: what precedes and what follows the first "\n====\n".
inline std::array<std::string_view, 2> halves(std::string_view bytes) {
  constexpr std::string_view kBorder = "\n====\n";
  const std::size_t at = bytes.find(kBorder);
  if (at == std::string_view::npos) return {bytes, {}};
  return {bytes.substr(0, at), bytes.substr(at + kBorder.size())};
}

/// Calls `read` and demands that it succeeds or refuses in one sentence that names the input.
template <class Read>
int reads_or_refuses(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    const std::string_view sentence = error.what();
    if (sentence.find(folder().string()) == std::string_view::npos || sentence.find('\n') != std::string_view::npos ||
        sentence.size() > 2000) {
      std::fprintf(stderr, "not one sentence about the file: %s\n", error.what());
      std::abort();
    }
  }
  return 0;
}

/// Calls `use` and demands that it succeeds or throws an error of ours.
template <class Use>
int succeeds_or_fails(Use&& use) {
  try {
    use();
  } catch (const Error&) {
  }
  return 0;
}

struct Target {
  int (*run)(const std::uint8_t*, std::size_t);  ///< data and its size, as libFuzzer hands them over; returns 0
  /// Inputs to begin with, beside those in the corpus: of formats that change with the program. Null: none.
  std::vector<std::string> (*seeds)(const std::filesystem::path& corpus) = nullptr;
};

inline std::map<std::string, Target>& targets() {
  static std::map<std::string, Target> known;
  return known;
}

}  // namespace gpvc::fuzz

/// GPVC_FUZZ_TARGET(name) { ... } defines a target, which sees `data` and `size`; GPVC_FUZZ_TARGET(name, seeds) one with
/// Target::seeds.
#define GPVC_FUZZ_TARGET(name, ...)                                                                                  \
  static int run_##name(const std::uint8_t* data, std::size_t size);                                                 \
  static const bool kListed_##name = targets().emplace(#name, Target{run_##name __VA_OPT__(, ) __VA_ARGS__}).second; \
  static int run_##name([[maybe_unused]] const std::uint8_t* data, [[maybe_unused]] std::size_t size)
