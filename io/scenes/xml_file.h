// An XML file with places for error messages, on pugixml.
#pragma once

#include <filesystem>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"

namespace gpvc::io {

class XmlFile {
 public:
  /// Throws InputError where the text is no XML or ends early. Only named: `file`. Borrowed until the end: `file` and
  /// `text`.
  XmlFile(const std::filesystem::path& file, std::string_view text);

  /// The document's root. Throws unless it has this name.
  pugi::xml_node root(std::string_view name) const;
  /// "line 12". O(log lines) after the first call.
  std::string place(const pugi::xml_node& node) const;
  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& reason) const {
    throw InputError(file_, place(node), reason);
  }

  /// The text of the child, without the blanks around it; empty when there is no such child.
  static std::string_view text(const pugi::xml_node& parent, const char* child);
  /// nullopt when there is no such child. Throws when its text is no finite number.
  std::optional<double> number(const pugi::xml_node& parent, const char* child) const;
  /// Throws also when there is no such child.
  double needed(const pugi::xml_node& parent, const char* child) const;
  /// The numbers that the node holds, with blanks between. Throws unless they are `count` finite ones.
  std::vector<double> numbers(const pugi::xml_node& node, std::size_t count) const;
  /// As needed(), for a whole number from 1 to 2^24.
  int side(const pugi::xml_node& parent, const char* child) const;
  const std::filesystem::path& path() const { return file_; }

 private:
  const std::filesystem::path& file_;
  std::string_view text_;
  pugi::xml_document document_;
  mutable std::vector<std::ptrdiff_t> line_ends_;  ///< offsets, the text's end last; found when first needed
};

/// The first bytes of a document that xml_root needs; what comes before the root is shorter.
inline constexpr std::size_t kXmlHead = std::size_t{1} << 14;

/// The name of a document's root, from its first bytes; empty if it is not XML.
std::string xml_root_in(std::string_view head);
/// The same of a file.
std::string xml_root(const std::filesystem::path& file);

}  // namespace gpvc::io
