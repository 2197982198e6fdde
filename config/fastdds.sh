# To be sourced: Fast DDS by the profile beside this file, where nothing else is asked for.
#
# With the range LOCALHOST rmw_fastrtps adds shared memory to whatever is configured, and ignores
# FASTDDS_BUILTIN_TRANSPORTS; so the range is left to the profile, which speaks on this machine only.
if [[ ${RMW_IMPLEMENTATION:-} == rmw_fastrtps_cpp && -z ${FASTDDS_DEFAULT_PROFILES_FILE:-} ]]; then
  FASTDDS_DEFAULT_PROFILES_FILE=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/fastdds.xml
  export FASTDDS_DEFAULT_PROFILES_FILE RMW_FASTRTPS_USE_QOS_FROM_XML=1
  export ROS_AUTOMATIC_DISCOVERY_RANGE=SYSTEM_DEFAULT
fi
