// Cost tables on disk: our three arrays, and mvs-texturing's sparse table.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

namespace fs = std::filesystem;

void check_costs(const fs::path& file, std::span<const float> costs) {
  for (std::size_t i = 0; i < costs.size(); ++i)
    if (!(costs[i] >= 0) || !std::isfinite(costs[i]))
      throw InputError(file, "entry " + std::to_string(i), "a cost is negative or not finite");
}

template <typename T>
std::vector<T> read_vector(const fs::path& file) {
  io::NpyArray<T> array = io::read_npy<T>(file);
  if (array.shape.size() != 1) throw InputError(file, "", "expected an array of one dimension");
  return std::move(array.values);
}

// Choosing takes time and memory in proportion to the largest view number, which no size of the file bounds: what the
// 16 bits of mvs-texturing's table hold is more than any flight, and anything above a number misread.
constexpr std::uint32_t kViewNumbers = 1u << 16;

void check_views(const fs::path& file, const CostTable& table) {
  for (std::size_t face = 0; face + 1 < table.first.size(); ++face)
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i) {
      if (i > table.first[face] && table.views[i] <= table.views[i - 1])
        throw InputError(file, "face " + std::to_string(face), "its views do not ascend");
      if (table.views[i] >= kViewNumbers)
        throw InputError(file, "face " + std::to_string(face),
                         "has the view " + std::to_string(table.views[i]) + "; expected numbers below " +
                             std::to_string(kViewNumbers));
    }
}

CostTable read_folder(const fs::path& folder) {
  const std::vector<std::uint32_t> counts = read_vector<std::uint32_t>(folder / "counts.npy");
  CostTable table;
  table.views = read_vector<std::uint32_t>(folder / "views.npy");
  table.costs = read_vector<float>(folder / "costs.npy");
  table.first.reserve(counts.size() + 1);
  table.first.push_back(0);
  for (const std::uint32_t count : counts) table.first.push_back(table.first.back() + count);
  if (table.first.back() != table.views.size())
    throw InputError(folder / "counts.npy", "",
                     "the counts add up to " + std::to_string(table.first.back()) + ", but views.npy has " +
                         std::to_string(table.views.size()) + " entries");
  if (table.views.size() != table.costs.size())
    throw InputError(folder / "costs.npy", "",
                     "has " + std::to_string(table.costs.size()) + " entries, but views.npy has " +
                         std::to_string(table.views.size()));
  check_costs(folder / "costs.npy", table.costs);
  check_views(folder / "views.npy", table);
  return table;
}

// --- mvs-texturing

struct SparseEntry {
  std::uint32_t face;
  std::uint16_t view;
  float cost;
};

constexpr std::size_t kEntryBytes = 10;

SparseEntry entry_at(const std::string& bytes, std::size_t i) {
  SparseEntry entry;
  const char* at = bytes.data() + i * kEntryBytes;
  std::memcpy(&entry.face, at, 4);
  std::memcpy(&entry.view, at + 4, 2);
  std::memcpy(&entry.cost, at + 6, 4);
  return entry;
}

void sort_by_view(CostTable& table, const fs::path& file) {
  std::vector<std::pair<std::uint32_t, float>> row;
  for (std::size_t face = 0; face + 1 < table.first.size(); ++face) {
    row.clear();
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i)
      row.emplace_back(table.views[i], table.costs[i]);
    std::sort(row.begin(), row.end());
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0 && row[i].first == row[i - 1].first)
        throw InputError(file, "face " + std::to_string(face), "has a view twice");
      table.views[table.first[face] + i] = row[i].first;
      table.costs[table.first[face] + i] = row[i].second;
    }
  }
}

CostTable read_sparse_table(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be opened");
  std::string magic, version;
  std::uint64_t faces = 0, views = 0, entries = 0;
  in >> magic >> version >> faces >> views >> entries;
  if (!in || magic != "SPT" || in.get() != '\n')
    throw InputError(file, "line 1", "expected 'SPT 0.2 FACES VIEWS ENTRIES'");
  const std::uint64_t size = fs::file_size(file), header = static_cast<std::uint64_t>(in.tellg());
  if ((size - header) / kEntryBytes < entries)
    throw InputError(file, "byte " + std::to_string(size),
                     "the file ends before its " + std::to_string(entries) + " entries");
  // Faces without an entry take no byte of the file, so that its size alone bounds nothing: a table that has an entry
  // for less than one face in 1024 is a number misread, not a mesh.
  constexpr std::uint64_t kMostFacesPerEntry = 1024, kAlways = 1u << 20;
  if (faces > 0xFFFFFFFEu || faces > kAlways + kMostFacesPerEntry * entries)
    throw InputError(
        file, "line 1",
        "claims " + std::to_string(faces) + " faces, too many for its " + std::to_string(entries) + " entries");
  std::string bytes(entries * kEntryBytes, '\0');
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) throw InputError(file, "", "cannot be read");

  CostTable table;
  table.first.assign(faces + 1, 0);
  for (std::size_t i = 0; i < entries; ++i) {
    const SparseEntry entry = entry_at(bytes, i);
    if (entry.face >= faces || entry.view >= views)
      throw InputError(file, "entry " + std::to_string(i), "its face or view is out of range");
    ++table.first[entry.face + 1];
  }
  for (std::size_t face = 0; face < faces; ++face) table.first[face + 1] += table.first[face];
  table.views.resize(entries);
  table.costs.resize(entries);
  std::vector<std::size_t> next(table.first.begin(), table.first.end() - 1);
  for (std::size_t i = 0; i < entries; ++i) {
    const SparseEntry entry = entry_at(bytes, i);
    table.views[next[entry.face]] = entry.view;
    table.costs[next[entry.face]++] = entry.cost;
  }
  check_costs(file, table.costs);
  sort_by_view(table, file);
  return table;
}

}  // namespace

CostTable read_costs(const fs::path& path) {
  return fs::is_directory(path) ? read_folder(path) : read_sparse_table(path);
}

void write_costs(const fs::path& folder, const CostTable& table) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw OutputError(folder, error.message());
  std::vector<std::uint32_t> counts(table.faces());
  for (std::size_t face = 0; face < counts.size(); ++face)
    counts[face] = static_cast<std::uint32_t>(table.first[face + 1] - table.first[face]);
  const std::size_t faces[] = {counts.size()}, entries[] = {table.views.size()};
  io::write_npy(folder / "counts.npy", counts, faces);
  io::write_npy(folder / "views.npy", table.views, entries);
  io::write_npy(folder / "costs.npy", table.costs, entries);
}

}  // namespace gpvc::labeling
