// Objects with a running memory are not pickled or copied: two of them would go on from one memory without knowing.
#ifndef DEHYST_NATIVE_NO_PICKLE_H
#define DEHYST_NATIVE_NO_PICKLE_H

#include "arrays.h"

// Let pickle and copy say what to do instead, of a class that has `save` and `restore`.
template <class T>
void refuse_pickling(nb::class_<T> &bound)
{
    bound.def("__reduce__", [](const nb::object &self) -> nb::object {
        const std::string name = nb::str(self.type().attr("__name__")).c_str();
        throw nb::type_error(("cannot pickle or copy a " + name + ": it holds the memory of something that runs. Keep "
                              "image = it.save(), which can be pickled, and call restore(image) of one that was made "
                              "with the same parameters; the model that it was made from can be pickled too")
                                 .c_str());
    });
}

#endif
