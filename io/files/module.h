// Modules: parts of the program that load many libraries, and are opened where they are needed.
#pragma once

#include <dlfcn.h>

#include <string>

namespace gpvc::io {

/// What a module's entry, a function without arguments, returns; null where the module cannot be opened.
template <typename Functions>
struct Module {
  const Functions* functions = nullptr;
  std::string why{};  ///< there are none
};

/// Modules are found by the RUNPATH of the program or library that this is part of, and stay open to the end.
template <typename Functions>
Module<Functions> open_module(const char* file, const char* entry_name) {
  using Entry = const Functions* (*)();
  if (void* module = ::dlopen(file, RTLD_NOW | RTLD_LOCAL))
    if (const auto entry = reinterpret_cast<Entry>(::dlsym(module, entry_name))) return {entry(), ""};
  const char* why = ::dlerror();
  return {nullptr, why == nullptr ? file : why};
}

}  // namespace gpvc::io
