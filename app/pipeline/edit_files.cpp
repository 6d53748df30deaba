#include "app/pipeline/edit_files.h"

#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

#include "app/pipeline/stored.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

// To be raised when anything that the files hold, as labeling::FaceRecord, takes another form or meaning.
constexpr std::uint32_t kFormat = 3;

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
  io::WorkStore store(folder.in_making());
  store.keep(name, key, write);
  if (const auto failure = store.failure()) throw OutputError(folder.path() / name, *failure);
}

void read_result(const fs::path& from, const char* name, const io::WorkKey& key,
                 const std::function<void(io::WorkStore::Reader&)>& read) {
  const io::WorkStore store(from);
  if (!fs::exists(from / "model.obj")) throw InputError(from, "", "holds no textured model (model.obj)");
  if (!fs::exists(from / name))
    throw InputError(from / name, "", "is missing, without which the result cannot be changed", {Cure::make_editable});
  if (!store.has(name, key))
    throw InputError(from / name, "", "is of another version of gpvc, or of another result", {Cure::make_editable});
  if (!store.read(name, key, read)) throw InputError(from / name, "", "is damaged", {Cure::make_editable});
}

}  // namespace

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
    collector.take_judgement(in.get<std::vector<labeling::ViewAgreement>>());
    for (auto left = in.get<std::size_t>(); left > 0; --left)
      coverage.add(std::make_shared<const PackedCoverage>(in.get<PackedCoverage>()));
  });
}

void write_edit_model(const EditModel& m, OutputFolder& folder) {
  write_result(kEditModelFile, model_key(), folder, [&](io::WorkStore::Writer& out) { out.add(m); });
}

EditModel read_edit_model(const fs::path& from) {
  EditModel model;
  read_result(from, kEditModelFile, model_key(), [&](io::WorkStore::Reader& in) { model = in.get<EditModel>(); });
  return model;
}

double edit_bytes(const Workload& work) {
  // A record, and coverage of partial faces, of which there are few; of a face its label, corners, page, chart and its share
  // of texture coordinates.
  return 24 * work.pairs + 32 * work.faces;
}

}  // namespace gpvc::pipeline
