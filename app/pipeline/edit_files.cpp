#include "app/pipeline/edit_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "app/pipeline/given_layout.h"
#include "app/pipeline/stored.h"
#include "app/pipeline/texture_files.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

// To be raised when anything that the files hold, as labeling::FaceRecord, takes another form or meaning.
constexpr std::uint32_t kFormat = 7;

io::WorkKey model_key() {
  io::WorkHash hash;
  hash.add(std::string_view("gpvc edit"));
  hash.add(kFormat);
  return hash.key();
}

// The views belong to the model beside them.
io::WorkKey views_key(const ResultKeys& keys) {
  io::WorkHash hash;
  hash.add(model_key());
  hash.add(keys);
  return hash.key();
}

void write_result(const char* name, const io::WorkKey& key, OutputFolder& folder,
                  const std::function<void(io::WorkStore::Writer&)>& write) {
  folder.file(name);
  if (std::ranges::find(folder.promised(), kEditHashesFile) == folder.promised().end()) folder.file(kEditHashesFile);
  io::WorkStore store(folder.in_making(), kEditHashesFile);
  store.keep(name, key, write);
  if (const auto failure = store.failure()) throw *failure;
}

void read_result(const fs::path& from, const char* name, const io::WorkKey& key,
                 const std::function<void(io::WorkStore::Reader&)>& read) {
  const io::WorkStore store(from, kEditHashesFile);
  if (!fs::exists(from / "model.obj")) throw InputError(from, "", "holds no textured model (model.obj)");
  for (const char* needed : {name, kEditHashesFile})
    if (!fs::exists(from / needed))
      throw InputError(from / needed, "", "is missing, without which the result cannot be changed",
                       {Cure::make_editable});
  if (!store.has(name, key))
    throw InputError(from / name, "", "is of another version of gpvc, or of another result", {Cure::make_editable});
  if (!store.read(name, key, read)) throw InputError(from / name, "", "is damaged", {Cure::make_editable});
}

bool is_of_views(ViewId view, const Input& input) { return index(view) < input.scene.views.size(); }

// Corners in [0, 1] of pages that are there. Where places are given, some faces have none.
bool is_sound(const io::TexturedModel& model, std::size_t faces, std::size_t pages, bool may_lack_pages) {
  return model.face_texcoords.size() == faces && model.face_page.size() == faces &&
         std::ranges::all_of(model.texcoords,
                             [](const io::TexCoord& t) { return t.u >= 0 && t.u <= 1 && t.v >= 0 && t.v <= 1; }) &&
         std::ranges::all_of(
             model.face_page,
             [&](std::uint32_t page) { return page < pages || (may_lack_pages && page == io::kNoPage); }) &&
         std::ranges::all_of(model.face_texcoords, [&](const auto& corners) {
           return std::ranges::all_of(corners, [&](std::uint32_t corner) { return corner < model.texcoords.size(); });
         });
}

bool is_page_size(const std::array<int, 2>& size) {
  constexpr int kMost = 1 << 16;
  return size[0] > 0 && size[1] > 0 && size[0] <= kMost && size[1] <= kMost;
}

bool is_sound(const EditModel& m, const Input& input, bool may_lack_pages) {
  const std::size_t faces = input.mesh.faces.size(), pages = m.page_sizes.size();
  // New charts are numbered after these, and there are as many as faces at most, and as many borders.
  const std::uint64_t charts = UINT32_MAX - std::min<std::uint64_t>(UINT32_MAX, 2 * std::uint64_t{faces} + 1);
  return m.labels.size() == faces && m.face_chart.size() == faces && m.page_files.size() == pages &&
         (m.exposure.empty() || m.exposure.size() == input.scene.views.size()) &&
         (m.alignment.empty() || m.alignment.size() == input.scene.views.size()) && m.reduction > 0 &&
         m.reduction <= 1 && is_sound(m.model, faces, pages, may_lack_pages) &&
         std::ranges::all_of(m.page_sizes, is_page_size) &&
         std::ranges::all_of(m.labels, [&](ViewId view) { return view == kNoView || is_of_views(view, input); }) &&
         std::ranges::all_of(m.face_chart, [&](std::uint32_t chart) { return chart < charts; }) &&
         std::ranges::all_of(m.exposure, [](const auto& exposure) { return atlas::is_sound(exposure); }) &&
         std::ranges::all_of(m.alignment, [](const ShiftField& field) { return atlas::is_sound(field); }) &&
         std::ranges::all_of(m.rules, [&](const ViewRule& rule) { return is_sound(rule, input.scene.views.size()); });
}

}  // namespace

io::WorkKey page_file_key(const fs::path& file) {
  io::WorkHash hash;
  hash.add_file(file);
  return hash.key();
}

void write_edit_views(const Input& input, const ResultKeys& keys, const labeling::CandidateCollector& collector,
                      const CoverageStore& coverage, OutputFolder& folder) {
  write_result(kEditViewsFile, views_key(keys), folder, [&](io::WorkStore::Writer& out) {
    for (const ViewId id : input.views) out.add(collector.statistics_of(id));
    out.add(collector.agreement());
    out.add(coverage.views().size());
    for (const auto& packed : coverage.views()) out.add(*packed);
  });
}

void read_edit_views(const fs::path& from, const Input& input, const ResultKeys& keys,
                     labeling::CandidateCollector& collector, CoverageStore& coverage) {
  read_result(from, kEditViewsFile, views_key(keys), [&](io::WorkStore::Reader& in) {
    for (const ViewId id : input.views)
      if (!collector.add_statistics(id, in.get<std::vector<std::byte>>())) in.refuse();
    auto agreement = in.get<std::vector<labeling::ViewAgreement>>();
    if (!std::ranges::all_of(agreement, [&](const auto& each) { return is_of_views(each.view, input); })) in.refuse();
    collector.take_judgement(std::move(agreement));
    std::size_t next = 0;  // each view once
    for (auto left = in.get<std::size_t>(); left > 0; --left) {
      auto packed = in.get<PackedCoverage>();
      if (!is_of_views(packed.view, input) || index(packed.view) < next) in.refuse();
      next = index(packed.view) + 1;
      if (!is_sound(packed, input.mesh, input.scene.views[index(packed.view)])) in.refuse();
      coverage.add(std::make_shared<const PackedCoverage>(std::move(packed)));
    }
  });
}

void copy_edit_views(const fs::path& from, const ResultKeys& keys, OutputFolder& folder) {
  write_result(kEditViewsFile, views_key(keys), folder, [&](io::WorkStore::Writer& out) {
    read_result(from, kEditViewsFile, views_key(keys), [&](io::WorkStore::Reader& in) {
      std::vector<std::byte> part(std::size_t{1} << 20);
      for (std::size_t bytes; (bytes = std::min(in.left(), part.size())) > 0;) {
        in.read(part.data(), bytes);
        out.write(part.data(), bytes);
      }
    });
  });
}

void write_edit_model(const Input& input, EditModel m, io::ImageFormat pages, OutputFolder& folder) {
  m.page_files.clear();
  for (std::size_t p = 0; p < m.page_sizes.size(); ++p)
    m.page_files.push_back(page_file_key(folder.in_making() / page_file_name(input, p, pages)));
  write_result(kEditModelFile, model_key(), folder, [&](io::WorkStore::Writer& out) { out.add(m); });
}

EditModel read_edit_model(const fs::path& from) {
  EditModel model;
  read_result(from, kEditModelFile, model_key(), [&](io::WorkStore::Reader& in) { model = in.get<EditModel>(); });
  return model;
}

void check_edit_model(const fs::path& from, const Input& input, const EditModel& model, bool may_lack_pages) {
  if (!is_sound(model, input, may_lack_pages))
    throw InputError(from / kEditModelFile, "", "holds values that no result of this input has", {Cure::make_editable});
}

double edit_bytes(const Workload& work) {
  // A record, and coverage of partial faces, of which there are few; of a face its label, corners, page, chart and its share
  // of texture coordinates.
  return 24 * work.pairs + 32 * work.faces;
}

}  // namespace gpvc::pipeline
