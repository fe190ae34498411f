# Fails unless one file holds the whole text of another. usage: cmake -DTEXT= -DQUOTED= -P this
file(READ ${TEXT} text)
file(READ ${QUOTED} quoted)
string(FIND "${text}" "${quoted}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "${TEXT} does not quote ${QUOTED} as it is")
endif()
