// Structs whose fields are listed once: what Python's constructor, attributes and pickle know of them.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "common.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {

/// A member by its name in Python; the docstring is its attribute's.
template <class Struct, class Value>
struct Field {
  Field(const char* python_name, Value Struct::* pointer, const char* docstring = nullptr)
      : name(python_name), member(pointer), doc(docstring) {}

  const char* name;
  Value Struct::* member;
  const char* doc;
};

/// What Python sees of a value: the value itself, unless this is specialised for its type.
template <class Value>
struct Seen {
  using Type = Value;
  static const Value& to_python(const Value& value) { return value; }
  static Value from_python(const char*, Value value) { return value; }
};

template <class Struct>
void require_exactly(std::initializer_list<const char*> names, const py::dict& state) {
  const auto type = py::type::of<Struct>().attr("__name__").template cast<std::string>();
  for (const auto& item : state) {
    const auto given = py::str(item.first).cast<std::string>();
    require(std::find(names.begin(), names.end(), given) != names.end(), type + " has no field '" + given + "'");
  }
  for (const char* name : names) require(state.contains(name), type + "'s field '" + name + "' is missing");
}

/// A field of a pickled state. ValueError that names it for a value of another type: pybind11 alone would
/// take None and numbers for a bool.
template <class Struct, class Value>
Value unpickled(const Field<Struct, Value>& field, const py::dict& state) {
  const py::object given = state[field.name];
  try {
    if (!std::is_same_v<Value, bool> || py::isinstance<py::bool_>(given))
      return Seen<Value>::from_python(field.name, given.template cast<typename Seen<Value>::Type>());
  } catch (const py::cast_error&) {
  } catch (const py::reference_cast_error&) {  // of None for a struct
  }
  const auto type = py::type::of<Struct>().attr("__name__").template cast<std::string>();
  throw std::invalid_argument(type + "'s field '" + field.name + "' is " +
                              py::repr(given).template cast<std::string>() + ", of another type");
}

/// Pickles as {name: value}, so that a field that was added or moved is never taken for another. Unpickling raises
/// ValueError for an unknown or missing name, a value of another type and what validate() refuses.
template <class Struct, class... Values>
auto pickled_by_name(Field<Struct, Values>... fields) {
  return py::pickle(
      [fields...](const Struct& self) {
        py::dict state;
        ((state[fields.name] = Seen<Values>::to_python(self.*fields.member)), ...);
        return state;
      },
      [fields...](const py::dict& state) {
        require_exactly<Struct>({fields.name...}, state);
        Struct made{};
        ((made.*fields.member = unpickled(fields, state)), ...);
        validate(made);
        return made;
      });
}

/// Equal where all fields are; printed as the call that makes it.
template <class Struct, class... Values>
void bind_value(py::class_<Struct>& type, Field<Struct, Values>... fields) {
  const auto values = [fields...](const Struct& self) {
    return py::make_tuple(py::cast(Seen<Values>::to_python(self.*fields.member))...);
  };
  type.def(
      "__eq__", [values](const Struct& a, const Struct& b) { return values(a).equal(values(b)); }, py::is_operator());
  type.def("__hash__", [values](const Struct& self) { return py::hash(values(self)); });
  type.def("__repr__", [fields...](const py::object& self) {
    std::string said;
    ((said += std::string(said.empty() ? "" : ", ") + fields.name + "=" +
              py::repr(self.attr(fields.name)).template cast<std::string>()),
     ...);
    return py::type::of(self).attr("__name__").template cast<std::string>() + "(" + said + ")";
  });
}

/// Binds a struct of settings: keywords with the struct's own defaults, checked by validate(); attributes that cannot
/// be set; equal where all fields are; pickle by name.
template <class Struct, class... Values>
void bind_settings(py::module_& m, const char* name, const char* doc, Field<Struct, Values>... fields) {
  const Struct defaults{};
  py::class_<Struct> type(m, name, doc);
  type.def(py::init([fields...](typename Seen<Values>::Type... values) {
             Struct made{};
             ((made.*fields.member = Seen<Values>::from_python(fields.name, std::move(values))), ...);
             validate(made);
             return made;
           }),
           py::kw_only(),
           (py::arg(fields.name).noconvert(std::is_same_v<Values, bool>) =
                Seen<Values>::to_python(defaults.*fields.member))...);
  const auto bind_attribute = [&type]<class Value>(Field<Struct, Value> field) {
    using Type = typename Seen<Value>::Type;
    const auto get = [field](const Struct& self) -> Type { return Seen<Value>::to_python(self.*field.member); };
    type.def_property_readonly(field.name, get, field.doc);
  };
  (bind_attribute(fields), ...);
  bind_value(type, fields...);
  type.def(pickled_by_name(fields...));
}

}  // namespace lfdcore
