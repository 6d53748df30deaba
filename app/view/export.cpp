// The page and its results as a folder for any web server.
#include <nlohmann/json.hpp>

#include "app/view/page_files.h"
#include "app/view/session.h"
#include "io/file_bytes.h"
#include "io/output_file.h"

namespace gpvc::view {
namespace {

namespace fs = std::filesystem;

void write_reply(const fs::path& file, const Reply& reply) {
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  if (failed) throw OutputError(file, "cannot be written: " + failed.message());
  if (reply.body)
    io::write_file(file, *reply.body);
  else
    io::copy_file(reply.file, file);
}

}  // namespace

void Session::write_to(const fs::path& folder) {
  for (const PageFile& file : page_files())
    write_reply(folder / file.name, bytes_reply(std::string(file.type), std::string(file.content)));
  evaluate::Json page = evaluate::Json::parse(*page_json().body);
  // Nobody answers there.
  for (const char* name : {"live", "asks", "judged", "changes"}) page[name] = false;
  page["rules"] = nullptr;
  write_reply(folder / "page.json", bytes_reply("application/json", evaluate::json_text(page)));
  for (std::size_t n = 0; n < results_.size(); ++n) {
    const fs::path below = folder / "results" / std::to_string(n);
    for (const std::string& path : result(n)->paths()) write_reply(below / path, result(n)->answer(path));
  }
  for (const std::string& path : tiles_) write_reply(folder / "tileset" / path, tile(path));
  if (!input_.scene) return;
  for (const ViewId view : input_.scene->run->input.views)
    write_reply(folder / "photos" / std::to_string(index(view)), photo(index(view)));
}

}  // namespace gpvc::view
