// What a text must be before an XML parser sees it.
#pragma once

#include <string>

namespace lfdcore {

/// Throws DataError for XML that is too large or too deep, has more than 2000 links, a document type or entities (a way
/// to blow up memory or to read other files), or whose elements do not close.
void require_plain_xml(const std::string& xml);

}  // namespace lfdcore
