// PROJ as it is where no package of grids is installed.
#pragma once

#include <proj.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "tests/support/temporary_folder.h"

namespace gpvc::test {

/// While it lives, PROJ finds its database and no grid.
class WithoutGrids {
 public:
  WithoutGrids() {
    PJ_CONTEXT* context = proj_context_create();
    const char* database = proj_context_get_database_path(context);
    std::filesystem::create_symlink(database != nullptr ? database : "", folder_.path() / "proj.db");
    proj_context_destroy(context);
    set("PROJ_DATA", folder_.path());  // from PROJ 9.1 on
    set("PROJ_LIB", folder_.path());
    set("PROJ_SKIP_READ_USER_WRITABLE_DIRECTORY", "YES");
    set("PROJ_NETWORK", "OFF");
  }
  ~WithoutGrids() {
    for (const auto& [name, value] : before_) value ? setenv(name.c_str(), value->c_str(), 1) : unsetenv(name.c_str());
  }
  WithoutGrids(const WithoutGrids&) = delete;
  WithoutGrids& operator=(const WithoutGrids&) = delete;

 private:
  void set(const std::string& name, const std::string& value) {
    const char* before = std::getenv(name.c_str());
    before_[name] = before != nullptr ? std::optional<std::string>(before) : std::nullopt;
    setenv(name.c_str(), value.c_str(), 1);
  }
  TemporaryFolder folder_;
  std::map<std::string, std::optional<std::string>> before_;
};

}  // namespace gpvc::test
