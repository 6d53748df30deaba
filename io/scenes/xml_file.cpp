#include "io/scenes/xml_file.h"

#include <algorithm>
#include <cmath>

#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

std::string line_at(std::string_view text, std::ptrdiff_t offset) {
  const auto end = static_cast<std::ptrdiff_t>(text.size());
  const auto lines = std::count(text.begin(), text.begin() + std::clamp<std::ptrdiff_t>(offset, 0, end), '\n');
  return "line " + std::to_string(lines + 1);
}

}  // namespace

XmlFile::XmlFile(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {
  const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
  if (!result) {
    std::string reason = result.description();
    if (!reason.empty()) reason.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(reason.front())));
    throw InputError(file, line_at(text, result.offset), "expected well-formed XML: " + reason);
  }
  if (!document_.document_element()) throw InputError(file, "", "expected an XML document, found no element");
}

pugi::xml_node XmlFile::root(std::string_view name) const {
  const pugi::xml_node root = document_.document_element();
  if (root.name() != name) fail(root, "expected <" + std::string(name) + ">, found " + quote(root.name()));
  return root;
}

std::string XmlFile::place(const pugi::xml_node& node) const {
  if (line_ends_.empty()) {
    for (std::size_t at = text_.find('\n'); at != std::string_view::npos; at = text_.find('\n', at + 1))
      line_ends_.push_back(static_cast<std::ptrdiff_t>(at));
    line_ends_.push_back(static_cast<std::ptrdiff_t>(text_.size()));
  }
  const auto line = std::ranges::lower_bound(line_ends_, node.offset_debug()) - line_ends_.begin();
  return "line " + std::to_string(line + 1);
}

std::string_view XmlFile::text(const pugi::xml_node& parent, const char* child) {
  return trimmed(parent.child_value(child));
}

std::optional<double> XmlFile::number(const pugi::xml_node& parent, const char* child) const {
  const pugi::xml_node node = parent.child(child);
  if (!node) return std::nullopt;
  const std::string_view word = trimmed(node.child_value());
  const std::optional<double> value = number_from(word);
  if (!value || !std::isfinite(*value))
    fail(node, "expected a finite number in " + std::string(child) + ", found " + quote(word));
  return value;
}

double XmlFile::needed(const pugi::xml_node& parent, const char* child) const {
  const std::optional<double> value = number(parent, child);
  if (!value) fail(parent, std::string(parent.name()) + " has no " + child);
  return *value;
}

std::vector<double> XmlFile::numbers(const pugi::xml_node& node, std::size_t count) const {
  std::string_view text = node.child_value();
  std::vector<double> values;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value))
      fail(node, "expected finite numbers in " + std::string(node.name()) + ", found " + quote(word));
    if (values.size() == count) fail(node, "more than " + std::to_string(count) + " numbers");
    values.push_back(*value);
  }
  if (values.size() != count)
    fail(node, "expected " + std::to_string(count) + " numbers in " + node.name() + ", found " +
                   std::to_string(values.size()));
  return values;
}

int XmlFile::side(const pugi::xml_node& parent, const char* child) const {
  const std::optional<int> side = image_side(needed(parent, child));
  if (!side) fail(parent.child(child), std::string(child) + " is not a whole number of 1 to 2^24 pixels");
  return *side;
}

std::string xml_root(const std::filesystem::path& file) { return xml_root_in(first_bytes(file, kXmlHead)); }

std::string xml_root_in(std::string_view head) {
  // Before the root there is markup alone; an archive can hold a document as it is.
  if (!trimmed(without_byte_order_mark(head)).starts_with('<')) return {};
  // Past the declaration, comments and a document type, the first '<' opens the root.
  for (std::size_t at = head.find('<'); at != std::string_view::npos; at = head.find('<', at)) {
    const std::string_view rest = head.substr(at + 1);
    if (rest.starts_with("!--")) {
      at = head.find("-->", at + 4);
    } else if (rest.starts_with("?") || rest.starts_with("!")) {
      at = head.find('>', at);
    } else {
      const std::size_t end = rest.find_first_of(" \t\r\n/>");
      return end == std::string_view::npos ? std::string() : std::string(rest.substr(0, end));
    }
    if (at == std::string_view::npos) break;
  }
  return {};
}

}  // namespace gpvc::io
