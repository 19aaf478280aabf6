/* The functions of FMI 3.0 that these components have no use for: each says so; a part of fmi3_cs.c. */

#define NOT_HERE(name, parameters, what)    \
    fmi3Status fmi3##name parameters        \
    {                                       \
        return unsupported(instance, what); \
    }

/* Of types that no variable has nothing may be asked; nothing at all may. */
#define NONE_HERE(name, parameters, what)                                  \
    fmi3Status fmi3##name parameters                                       \
    {                                                                      \
        return n ? unsupported(instance, what) : status(instance != NULL); \
    }

#define ASKED fmi3Instance instance, const fmi3ValueReference r[], size_t n
#define NO_STRUCTURE WL_NAME " has no structural parameters"
#define DESCRIBED "dependencies are in modelDescription.xml"

NOT_HERE(EnterStepMode, (fmi3Instance instance), WL_NAME " has no event mode to leave")
NOT_HERE(EnterConfigurationMode, (fmi3Instance instance), NO_STRUCTURE)
NOT_HERE(ExitConfigurationMode, (fmi3Instance instance), NO_STRUCTURE)
NOT_HERE(EvaluateDiscreteStates, (fmi3Instance instance), WL_NAME " has no event mode")
NOT_HERE(ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 t),
         WL_NAME " has no clocks")

#define NO_TYPE(type)                                                                                               \
    NONE_HERE(Get##type, (ASKED, fmi3##type v[], size_t m), WL_NAME " has no variables of type " #type)             \
    NONE_HERE(Set##type, (ASKED, const fmi3##type v[], size_t m), WL_NAME " has no variables of type " #type)

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(UInt64)
NO_TYPE(String)
NONE_HERE(GetBinary, (ASKED, size_t s[], fmi3Binary v[], size_t m), WL_NAME " has no variables of type Binary")
NONE_HERE(SetBinary, (ASKED, const size_t s[], const fmi3Binary v[], size_t m),
          WL_NAME " has no variables of type Binary")

#define NO_CLOCK(name, ...) NONE_HERE(name, (ASKED, __VA_ARGS__), WL_NAME " has no clocks")
NO_CLOCK(GetClock, fmi3Clock a[])
NO_CLOCK(SetClock, const fmi3Clock a[])
NO_CLOCK(GetShiftDecimal, fmi3Float64 a[])
NO_CLOCK(SetShiftDecimal, const fmi3Float64 a[])
NO_CLOCK(SetIntervalDecimal, const fmi3Float64 a[])
NO_CLOCK(GetIntervalDecimal, fmi3Float64 a[], fmi3IntervalQualifier b[])
NO_CLOCK(GetShiftFraction, fmi3UInt64 a[], fmi3UInt64 b[])
NO_CLOCK(SetShiftFraction, const fmi3UInt64 a[], const fmi3UInt64 b[])
NO_CLOCK(SetIntervalFraction, const fmi3UInt64 a[], const fmi3UInt64 b[])
NO_CLOCK(GetIntervalFraction, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier c[])

NOT_HERE(GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n), DESCRIBED)
NOT_HERE(GetVariableDependencies,
         (fmi3Instance instance, fmi3ValueReference r, size_t a[], fmi3ValueReference b[], size_t c[],
          fmi3DependencyKind d[], size_t n),
         DESCRIBED)
NOT_HERE(GetAdjointDerivative,
         (fmi3Instance instance, const fmi3ValueReference u[], size_t un, const fmi3ValueReference k[], size_t kn,
          const fmi3Float64 s[], size_t sn, fmi3Float64 v[], size_t vn),
         "gives directional derivatives, not adjoint ones")
