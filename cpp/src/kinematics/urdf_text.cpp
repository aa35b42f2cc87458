#include "urdf_text.hpp"

#include <string_view>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr std::size_t max_bytes = std::size_t{16} << 20;
constexpr int max_depth = 64, max_elements = 200'000, max_attributes = 64;
constexpr int max_links = 2000;  // the libraries recurse along chains of links: a stack holds some ten thousand

/// Walks over the markup of a text, counting open elements.
class Markup {
 public:
  explicit Markup(std::string_view text) : text_(text) {}

  void walk() {
    while ((at_ = text_.find('<', at_)) != text_.npos) step();
    if (depth_ != 0) throw DataError("the URDF is truncated: " + std::to_string(depth_) + " elements are not closed");
    if (elements_ == 0) throw DataError("this is no URDF: it has no XML elements");
  }

 private:
  bool starts(std::string_view what) const { return text_.substr(at_, what.size()) == what; }

  void skip_past(std::string_view end) {
    at_ = text_.find(end, at_);
    if (at_ == text_.npos) throw DataError("the URDF is truncated: it ends inside of a tag or a comment");
    at_ += end.size();
  }

  void step() {
    if (starts("<!--")) return skip_past("-->");
    if (starts("<![CDATA[")) return skip_past("]]>");
    if (starts("<?")) return declaration();
    if (starts("<!")) throw DataError("the URDF has a document type or entities, which are refused");
    if (starts("</")) {
      if (--depth_ < 0) throw DataError("the URDF closes more elements than it opens");
      return skip_past(">");
    }
    if (++elements_ > max_elements)
      throw DataError("the URDF has more than " + std::to_string(max_elements) + " elements, which is refused");
    if (starts("<link") && ++links_ > max_links)
      throw DataError("the URDF has more than " + std::to_string(max_links) + " links, which is refused");
    open_tag();
    if (depth_ > max_depth)
      throw DataError("the URDF nests elements deeper than " + std::to_string(max_depth) + ", which is refused");
  }

  /// <?xml ... ?>: the library ends it at the first '>', wherever that is.
  void declaration() {
    const std::size_t begin = at_;
    skip_past("?>");
    if (text_.substr(begin + 1, at_ - begin - 2).find_first_of("<>") != text_.npos)
      throw DataError("the URDF has markup in a processing instruction, which is refused");
  }

  /// To the end of <tag a="v">; a value may hold '>'.
  void open_tag() {
    char quote = 0;
    int attributes = 0;
    for (++at_; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
        if (++attributes > max_attributes)
          throw DataError("the URDF has an element of more than " + std::to_string(max_attributes) +
                          " attributes, which is refused");
      } else if (c == '>') {
        if (text_[at_ - 1] != '/') ++depth_;
        return;
      }
    }
    throw DataError("the URDF is truncated: it ends inside of a tag or a comment");
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0, elements_ = 0, links_ = 0;
};

}  // namespace

void require_plain_xml(const std::string& xml) {
  if (xml.size() > max_bytes)
    throw DataError("the URDF has " + std::to_string(xml.size()) + " bytes, at most 16 MiB are read");
  if (xml.find('\0') != xml.npos) throw DataError("this is no URDF: it holds zero bytes");
  Markup(xml).walk();
}

}  // namespace lfdcore
